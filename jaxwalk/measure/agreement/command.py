"""``jaxwalk agreement`` from its options to its files."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any, get_args

from rich.console import Console
from rich.table import Table

from jaxwalk.common import files
from jaxwalk.config import Engine
from jaxwalk.learn.policies import named, provenance
from jaxwalk.learn.policies.named import Subject
from jaxwalk.measure import screen
from jaxwalk.measure.agreement import differences, picture
from jaxwalk.measure.evaluate import evaluation
from jaxwalk.measure.evaluate.options import EvaluateArgs
from jaxwalk.measure.screen import Tell
from jaxwalk.task import backend

if TYPE_CHECKING:
    from jaxwalk.measure.agreement.options import AgreementArgs

TOLD = ("walking", "pushes", "threshold")  # of an evaluation, for each engine


def agreement(subject: Subject, args: AgreementArgs, tell: Tell = lambda what, share: None) -> dict[str, Any]:
    """The same trials by both engines, as the JSON that ``jaxwalk agreement`` writes.

    Args:
      tell: called with what is under way and the share of it that is done.
    """
    shared = {field.name: getattr(args, field.name) for field in dataclasses.fields(args)}
    del shared["out"]
    engines = {}
    for engine in get_args(Engine):
        options = EvaluateArgs(engine=engine, **shared)
        found = evaluation.evaluate(
            subject, options, lambda what, share, by=engine: tell(f"{by}: {what}", share)
        )
        engines[engine] = {name: found[name] for name in TOLD}
    first, second = engines.values()
    return {
        "engines": engines,
        **differences.compare(first, second, args.walkers, args.replicas),
        **provenance.stamp("agreement", args, subject, subject.config),
    }


def main(args: AgreementArgs) -> None:
    """The command."""
    subject = named.load(args.policy, height=args.height, mass=args.mass)
    files.make_folder("--out", args.out)
    console = Console()
    backend.begin(subject.config)
    with screen.bars(console) as tell:
        result = agreement(subject, args, tell)
    files.write_json(args.out / "agreement.json", result)
    title = f"{args.policy}: {args.replicas} walkers a cell and engine"
    picture.draw(result, title, args.out / "agreement.png")
    _print(console, args.policy, result)
    console.print(f"agreement.json and agreement.png in {args.out}", highlight=False)


def _print(console: Console, name: str, result: dict[str, Any]) -> None:
    engines = result["engines"]
    table = Table("", *engines, "difference", title=name)
    for key in differences.WALKING:
        values = [told["walking"][key] for told in engines.values()]
        table.add_row(key, *(f"{value:.4f}" for value in values), f"{result['walking'][key]:+.4f}")
    for way in ("forward", "backward"):
        sizes = [told["threshold"][way] for told in engines.values()]
        table.add_row(f"threshold {way}, N s", *("-" if size is None else f"{size:g}" for size in sizes))
    told = (f"{p['share']:.3f} ({p['low']:.3f}-{p['high']:.3f})" for p in result["pushes"])
    table.add_row("all pushes", *told)
    console.print(table)
    cells = result["cells"]
    console.print(
        f"95 % intervals overlap in {100 * cells['share_overlapping']:.1f} % of the cells; "
        f"largest difference of a cell {cells['largest_difference']:.2f}; "
        f"standard error of the speeds' difference {result['walking']['speed_standard_error']:.4f} m/s"
    )
