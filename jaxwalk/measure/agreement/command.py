"""``jaxwalk agreement`` from its options to its files."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.table import Table

from jaxwalk.config import Engine
from jaxwalk.learn.policies import named
from jaxwalk.learn.policies.named import Subject
from jaxwalk.measure import study
from jaxwalk.measure.agreement import differences, picture
from jaxwalk.measure.evaluate import evaluation
from jaxwalk.measure.protocol import PushTest
from jaxwalk.measure.screen import OnProgress

if TYPE_CHECKING:
    from jaxwalk.measure.agreement.options import AgreementArgs

TOLD = ("walking", "pushes", "threshold")  # of an evaluation, for each engine


def agreement(
    subject: Subject, test: PushTest, progress: OnProgress = lambda what, share: None
) -> dict[str, Any]:
    """The same trials by MJX and by the engine of ``test``, and how they differ."""
    beside: tuple[Engine, ...] = ("mjx", test.engine)
    engines = {}
    for engine in beside:
        by = dataclasses.replace(test, engine=engine)
        found = evaluation.evaluate(
            subject, by, lambda what, share, by=engine: progress(f"{by}: {what}", share)
        )
        engines[engine] = {name: found[name] for name in TOLD}
    first, second = engines.values()
    return {"engines": engines, **differences.compare(first, second, test.walkers, test.cell)}


def main(args: AgreementArgs) -> None:
    """Run ``jaxwalk agreement``."""
    subject = named.load(args.policy, height=args.height, mass=args.mass)
    title = f"{args.policy}: {args.replicas} walkers a cell and engine"
    study.carry_out(
        "agreement",
        args,
        subject.config,
        subject,
        lambda progress: agreement(subject, PushTest.of(args), progress),
        lambda console, result: _print(console, args.policy, result),
        lambda result: picture.draw(result, title),
    )


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
