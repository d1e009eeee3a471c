"""``jaxwalk evaluate`` from its options to its file."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Console
from rich.table import Table

from jaxwalk.learn.policies import named
from jaxwalk.measure import study
from jaxwalk.measure.evaluate import evaluation
from jaxwalk.measure.protocol import PushTest

if TYPE_CHECKING:
    from jaxwalk.measure.evaluate.options import EvaluateArgs


def main(args: EvaluateArgs) -> None:
    """Run ``jaxwalk evaluate``."""
    subject = named.asked(args)
    test = PushTest.of(args).sized(subject.config)
    study.carry_out(
        "evaluate",
        dataclasses.replace(args, replicas=test.replicas),
        subject.config,
        subject,
        lambda progress: evaluation.evaluate(subject, test, progress),
        lambda console, result: _print(console, args.policy, result),
    )


def _print(console: Console, name: str, result: dict[str, Any]) -> None:
    walking = result["walking"]
    table = Table(title=f"{name}: undisturbed", show_header=False)
    for key, value in walking.items():
        table.add_row(key, f"{value:.3f}")
    console.print(table)
    if "walls" in result:
        table = Table("between walls", *result["walls"])
        for key in result["walls"]["walking"]:
            table.add_row(key, *(f"{told[key]:.4f}" for told in result["walls"].values()))
        console.print(table)
    if "pushes" not in result:
        return
    pushes = result["pushes"]
    phases, replicas = len(pushes["phases"]), result["options"]["replicas"]
    title = f"pushed, {replicas} walkers at each of {phases} phases"
    table = Table("impulse, N s", "survival", "worst phase", "steady again", "mean recovery, s", title=title)
    rows = zip(
        pushes["impulses"], pushes["survival"], pushes["steady"], pushes["recovery_seconds"], strict=True
    )
    for impulse, survival, steady, recovery in rows:
        known = [x for x in recovery if x is not None]
        mean = f"{sum(known) / len(known):.2f}" if known else "-"
        table.add_row(
            f"{impulse:+g}",
            f"{np.mean(survival):.3f}",
            f"{min(survival):.3f}",
            f"{np.mean(steady):.3f}",
            mean,
        )
    console.print(table)
    found = result["threshold"]
    reached = {"forward": max(pushes["impulses"], default=0), "backward": -min(pushes["impulses"], default=0)}
    for direction, size in found.items():
        if size is None:
            continue
        more = " or more: the grid ends here" if size > 0 and math.isclose(size, reached[direction]) else ""
        console.print(f"threshold {direction}: {size:g} N s{more}")
