"""``jaxwalk paper`` from its options to its files."""

from __future__ import annotations

import dataclasses
import io
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
from PIL import Image
from rich.console import Console

from jaxwalk.common import figures, files
from jaxwalk.common.errors import UserError
from jaxwalk.learn.policies import named
from jaxwalk.learn.policies.named import Subject
from jaxwalk.measure import screen
from jaxwalk.options import lines
from jaxwalk.paper import page, trainings
from jaxwalk.paper.claim import Claim
from jaxwalk.paper.claims import registry
from jaxwalk.paper.lab import Lab
from jaxwalk.paper.options import NAMES, PaperArgs
from jaxwalk.paper.page import Ours, Page, Told
from jaxwalk.paper.store import Store
from jaxwalk.paper.verdict import Verdict
from jaxwalk.task import backend


def main(args: PaperArgs) -> None:
    """Run ``jaxwalk paper``."""
    console = Console(markup=False)
    subject = named.load(args.policy)
    claims = registry()
    Store(args, subject, {})  # what is wrong with the one that is there is said before hours of training
    files.make_folder("--out", args.out)
    if args.retrain:
        report = partial(console.print, highlight=False)
        trainings.train(args.trainings, args.out / "runs", tuple(trainings.TRAININGS), report)
    backend.begin(subject.config)
    store = Store(args, subject, {name: _inputs(claim, args) for name, claim in claims.items()})
    for name in store.claims:
        _said(claims[name], store)  # what is damaged is said before minutes of measuring
    wanted = [claims[name] for name in NAMES if name in (args.only or NAMES)]
    with screen.bars(console) as progress:
        lab = Lab(args.policy, args.trainings, args.quick, args.seed, progress)
        for place, claim in enumerate(wanted, 1):
            which = f"{place} of {len(wanted)}: {claim.name}"
            if claim.name in store.claims:
                date = store.claims[claim.name]["date"]
                console.print(f"{which}: used again, measured {date}", highlight=False)
                continue
            began = time.monotonic()
            bodies = claim.quick if args.quick else claim.bodies
            numbers = {body: claim.measure(lab, body) for body in bodies}
            store.keep(claim, numbers, time.monotonic() - began)
            console.print(f"{which}: measured in {time.monotonic() - began:.0f} s", highlight=False)
    told = [_told(claims[name], store, args) for name in NAMES if name in store.claims]
    _write(args, subject, store, told)
    for one in told:
        console.print(f"{one.claim.name:12} {one.verdict}", highlight=False)
    console.print(f"paper.md, paper.html, paper.json, figures and tables in {args.out}", highlight=False)


def _inputs(claim: Claim, args: PaperArgs) -> str:
    """What the claim depends on beside policy, options and version: the trainings that it looks at."""
    walls = ("walls",) if "walls" in (claim.quick if args.quick else claim.bodies) else ()
    return trainings.digest(args.trainings, (*claim.trainings, *walls))


@dataclass(frozen=True)
class _Said:
    """What a claim's numbers say: by body, over all, and its table and figure."""

    ours: tuple[Ours, ...]
    verdict: Verdict
    rows: list[dict[str, Any]]
    figure: Figure | None
    date: str


def _said(claim: Claim, store: Store) -> _Said:
    """What the numbers that ``store`` keeps of the claim say.

    Raises:
      UserError: the numbers that are kept are damaged.
    """
    kept = store.claims[claim.name]
    try:
        numbers: Mapping[Any, Any] = kept["numbers"]
        found, verdict = page.ours(claim, numbers)
        rows = [{"body": body, **row} for body, one in numbers.items() for row in claim.table(one)]
        figure = None if claim.draw is None else claim.draw(numbers)
        return _Said(found, verdict, rows, figure, str(kept["date"]))
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, ArithmeticError) as error:
        why = f"{type(error).__name__}: {error!s:.100}"
        raise UserError(
            f"{store.path}: the numbers of {claim.name} are damaged ({why}): move it away to have all "
            "measured anew"
        ) from error


def _told(claim: Claim, store: Store, args: PaperArgs) -> Told:
    """The claim on the page, its figure and its table written.

    Raises:
      UserError: its numbers are damaged, or a file cannot be written.
    """
    said = _said(claim, store)
    files.write_bytes(args.out / f"{claim.name}.csv", files.to_csv(said.rows) if said.rows else b"body\n")
    alone = dataclasses.replace(args, only=(claim.name,), retrain=False)
    told = Told(claim, said.ours, said.verdict, said.date, lines.line("paper", alone))
    if said.figure is None:
        return told
    picture = args.out / f"{claim.name}.png"
    figures.write_png(said.figure, picture)
    png = picture.read_bytes()
    width, height = Image.open(io.BytesIO(png)).size
    return dataclasses.replace(told, png=png, width=width, height=height)


def _write(args: PaperArgs, subject: Subject, store: Store, told: Sequence[Told]) -> None:
    content = Page(
        policy=args.policy,
        digest=subject.digest,
        walls=_walls(args),
        quick=args.quick,
        claims=told,
        command=lines.line("paper", dataclasses.replace(args, retrain=False)),
        machine=_machine(store.stamp),
    )
    files.write_bytes(args.out / "paper.md", page.markdown(content))
    files.write_bytes(args.out / "paper.html", page.html(content))
    store.write({one.claim.name: _plain(one) for one in told})


def _plain(told: Told) -> dict[str, Any]:
    """What ``paper.json`` says of a claim, beside its numbers."""
    claim = told.claim
    return {
        "title": claim.title,
        "paper": claim.says,
        "where": claim.where,
        "rule": claim.rule,
        "verdict": told.verdict,
        "bodies": {
            one.body: {"verdict": one.verdict, "checks": [{"says": s, "so": a} for s, a in one.answers]}
            for one in told.ours
        },
        "command": told.command,
    }


def _walls(args: PaperArgs) -> str:
    own = trainings.policy_file(args.trainings, "walls", 0)
    return f"{Path(own).name}, trained there" if own.is_file() else f"{args.policy}, as trained in the plane"


def _machine(stamp: Mapping[str, Any]) -> tuple[tuple[str, str], ...]:
    hardware, versions = stamp["hardware"], stamp["versions"]
    return (
        ("date", stamp["date"]),
        ("processor", f"{hardware['cpu']}, {hardware['cores']} cores, {hardware['memory_gb']:g} GB"),
        ("devices", ", ".join(hardware["devices"])),
        ("system", hardware["system"]),
        ("versions", ", ".join(f"{name} {version}" for name, version in versions.items())),
    )
