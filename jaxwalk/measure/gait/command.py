"""``jaxwalk gait`` from its options to its files."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from jaxwalk.common import files, untrusted
from jaxwalk.common.errors import UserError
from jaxwalk.learn.policies import named, provenance
from jaxwalk.learn.policies.named import Subject
from jaxwalk.measure import study
from jaxwalk.measure.gait import human, measures, picture, report, signals
from jaxwalk.measure.gait.report import Report
from jaxwalk.measure.screen import Tell

if TYPE_CHECKING:
    from jaxwalk.measure.gait.options import GaitArgs

JSON, CSV, PNG = "gait.json", "gait.csv", "gait.png"


def check_free(folder: Path, identity: dict[str, Any]) -> None:
    """See that ``folder`` holds no report but one of the same ``identity``, which may be written anew.

    Raises:
      UserError: it holds another report, or files of a report's names that are none.
    """
    path = folder / JSON
    if not os.path.lexists(path):
        for name in (CSV, PNG):
            if os.path.lexists(folder / name):
                raise UserError(f"{folder / name} is of no gait report: give --out another folder")
        return
    stored = untrusted.read_json(path, "give --out another folder")
    if not isinstance(stored, dict) or not identity.keys() <= stored.keys():
        raise UserError(f"{path} is no gait report: give --out another folder")
    if {name: stored[name] for name in identity} != untrusted.parse(files.to_json(identity)):
        raise UserError(
            f"{path} holds the report of another policy or other options: give --out another folder"
        )


def table_csv(found: Report) -> str:
    """The curves: per cent, quantity, unit, side, mean, standard deviation."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["percent", "quantity", "unit", "side", "mean", "sd"])
    for (name, side), curve in found.curves.items():
        for percent, (mean, sd) in enumerate(zip(curve.mean, curve.sd, strict=True)):
            writer.writerow([percent, name, signals.UNITS[name], side, f"{mean:.6g}", f"{sd:.6g}"])
    return text.getvalue()


def main(args: GaitArgs) -> None:
    """Run ``jaxwalk gait``."""
    subject = _subject(args, args.speed)
    stamp = provenance.stamp("gait", args, subject, subject.config)
    check_free(args.out, {name: stamp[name] for name in ("policy_digest", "options", "config")})
    made: list[Report] = []

    def measure(tell: Tell) -> dict[str, Any]:
        def walk(subject: Subject, what: str) -> Report:
            return report.make(subject, args.walkers, args.seconds, args.seed, partial(tell, what))

        made.append(walk(subject, "walking"))
        rows = [_at(args, speed, walk) for speed in args.speeds]
        return made[0].result | {"speeds": rows}

    body = subject.config.body
    title = f"{args.policy}: {args.walkers} walkers, {body.height:g} m, {body.mass:g} kg, unpushed"
    study.carry_out(
        "gait",
        args,
        subject.config,
        subject,
        measure,
        lambda console, result: _print(console, args.policy, result),
        lambda _: picture.draw(made[0], title),
        lambda _: table_csv(made[0]).encode(),
    )


def _subject(args: GaitArgs, speed: float) -> Subject:
    return named.load(
        args.policy,
        speed=speed,
        height=args.height,
        mass=args.mass,
        noise=args.noise,
        actuators=args.actuators,
    )


def _at(args: GaitArgs, speed: float, walk: Callable[[Subject, str], Report]) -> dict[str, Any]:
    """What is told of walkers asked for ``speed``; no measures where none of them walks."""
    try:
        found = walk(_subject(args, speed), f"at {speed:g} m/s").result
    except report.NoStride:
        return {"asked": speed, "fell": args.walkers, "measures": None}
    told = {name: found["measures"][name] for name in report.AT_SPEEDS}
    return {"asked": speed, "fell": found["fell"], "measures": told}


def _print(console: Console, name: str, result: dict[str, Any]) -> None:
    counted = result["strides"]
    title = (
        f"{name}: {counted['left']} left and {counted['right']} right strides, "
        f"{result['fell']} of {result['walkers']} walkers fell"
    )
    marks = {source: f"[{i}]" for i, source in enumerate(result["sources"], 1)}
    screen = Table("measure", "unit", "mean and SD", "people", title=title, box=box.SIMPLE)
    for measure, told in result["measures"].items():
        people = told.get("human")
        screen.add_row(
            measure.replace("_", " ").replace(" hz", " Hz"),
            told["unit"],
            f"{told['mean']:.3g} ± {told['sd']:.2g}",
            Text(f"{_people(people)} {marks[people['source']]}" if people else ""),
        )
    console.print(screen)
    symmetry = Table("symmetry index, per cent", "mean", "mean size", title="left and right", box=box.SIMPLE)
    for measure in measures.SYMMETRIC:
        told = result["symmetry"][measure]
        symmetry.add_row(measure.replace("_", " "), f"{told['mean']:+.1f}", f"{told['mean_size']:.1f}")
    console.print(symmetry)
    if result["speeds"]:
        console.print(_speeds(result["speeds"]))
    console.print("gait.json has the definitions of all", highlight=False)
    for source, what in result["sources"].items():
        console.print(Text(f"{marks[source]} {source}: {what}"))


def _speeds(rows: list[dict[str, Any]]) -> Table:
    """Walkers at each speed, and people's at the same; nothing of those that all fell."""
    names = [name.replace("_", " ") for name in report.AT_SPEEDS]
    screen = Table("asked, m/s", "fell", *names, title="at other speeds; people in brackets", box=box.SIMPLE)
    for row in rows:
        told = [
            f"{one['mean']:.3g}" + (f" ({one['human']['mean']:.3g})" if human.at_own_speed(one) else "")
            for one in (row["measures"] or {}).values()
        ]
        screen.add_row(f"{row['asked']:g}", str(row["fell"]), *told)
    return screen


def _people(people: dict[str, Any]) -> str:
    if people["low"] is None:
        return f"{people['mean']:.3g}"
    return f"{people['mean']:.3g} ({people['low']:.3g} to {people['high']:.3g})"
