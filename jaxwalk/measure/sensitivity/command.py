"""``jaxwalk sensitivity`` from its options to its files."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

from rich import box
from rich.console import Console
from rich.table import Table

from jaxwalk.config import Config
from jaxwalk.learn.policies import named
from jaxwalk.learn.policies.named import Subject
from jaxwalk.measure import one_change, study
from jaxwalk.measure.evaluate import evaluation
from jaxwalk.measure.protocol import PushTest
from jaxwalk.measure.screen import OnProgress
from jaxwalk.measure.sensitivity import picture
from jaxwalk.measure.sensitivity.settings import PARAMETERS, Setting, settings

if TYPE_CHECKING:
    from jaxwalk.measure.sensitivity.options import SensitivityArgs


def tried(subject: Subject, args: SensitivityArgs) -> list[Setting]:
    """The settings that are measured, the policy's own among them.

    Raises:
      UserError: a value that cannot be simulated.
    """
    values = {
        name: getattr(args, option.removeprefix("--").replace("-", "_"))
        for name, option in PARAMETERS.items()
    }
    if args.engine != "mjx":
        values["iterations"] = ()  # C MuJoCo takes as many as it needs, and ODE is not told
    return settings(subject.config, values)


def sensitivity(
    subject: Subject, plan: list[Setting], test: PushTest, progress: OnProgress = lambda what, share: None
) -> dict[str, Any]:
    """The same trials under every setting."""
    known: dict[Config, dict[str, Any]] = {}  # the policy's own configuration is among each parameter's
    rows = []
    for place, one in enumerate(plan):
        if one.config not in known:
            changed = dataclasses.replace(subject, config=one.config)
            known[one.config] = one_change.measured(evaluation.evaluate(changed, test), test)
        rows.append({"parameter": one.parameter, "value": one.value, "own": one.own, **known[one.config]})
        progress("settings", (place + 1) / len(plan))
    return {"rows": rows}


def main(args: SensitivityArgs) -> None:
    """Run ``jaxwalk sensitivity``."""
    subject = named.load(args.policy)
    plan = tried(subject, args)  # before minutes of work
    title = f"{args.policy}, {args.engine}: what its results owe to the physics' settings"
    study.carry_out(
        "sensitivity",
        args,
        subject.config,
        subject,
        lambda progress: sensitivity(subject, plan, PushTest.of(args), progress),
        lambda console, result: _print(console, args.policy, result["rows"]),
        lambda result: picture.draw(result, title),
    )


def _print(console: Console, name: str, rows: list[dict[str, Any]]) -> None:
    table = Table("setting (* own)", *one_change.COLUMNS, title=name, box=box.SIMPLE)
    for row in rows:
        setting = f"{row['parameter']} {row['value']:g}{'*' if row['own'] else ''}"
        table.add_row(setting, *one_change.cells(row))
    console.print(table)
