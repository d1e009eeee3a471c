"""``jaxwalk sensitivity`` from its options to its files."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

from rich import box
from rich.console import Console
from rich.table import Table

from jaxwalk.common import files
from jaxwalk.config import Config
from jaxwalk.learn.policies import named, provenance
from jaxwalk.learn.policies.named import Subject
from jaxwalk.measure import one_change, screen
from jaxwalk.measure.evaluate import evaluation
from jaxwalk.measure.evaluate.options import EvaluateArgs
from jaxwalk.measure.screen import Tell
from jaxwalk.measure.sensitivity import picture
from jaxwalk.measure.sensitivity.settings import PARAMETERS, Setting, settings
from jaxwalk.task import backend

if TYPE_CHECKING:
    from jaxwalk.measure.sensitivity.options import SensitivityArgs

_SHARED = ("policy", "walkers", "seconds", "impulses", "phases", "replicas", "engine", "seed")


def tried(subject: Subject, args: SensitivityArgs) -> list[Setting]:
    """Raises:
    UserError: a value that cannot be simulated.
    """
    values = {
        name: getattr(args, option.removeprefix("--").replace("-", "_"))
        for name, option in PARAMETERS.items()
    }
    if args.engine == "mujoco":
        values["iterations"] = ()  # as many as it takes, whatever is configured
    return settings(subject.config, values)


def sensitivity(
    subject: Subject, args: SensitivityArgs, tell: Tell = lambda what, share: None
) -> dict[str, Any]:
    """The same trials under every setting, as the JSON that ``jaxwalk sensitivity`` writes.

    Args:
      tell: called with what is under way and the share of it that is done.
    """
    options = EvaluateArgs(**{name: getattr(args, name) for name in _SHARED})
    plan = tried(subject, args)
    known: dict[Config, dict[str, Any]] = {}  # the policy's own configuration is among each parameter's
    rows = []
    for place, one in enumerate(plan):
        if one.config not in known:
            changed = dataclasses.replace(subject, config=one.config)
            known[one.config] = one_change.measured(evaluation.evaluate(changed, options), options)
        rows.append({"parameter": one.parameter, "value": one.value, "own": one.own, **known[one.config]})
        tell("settings", (place + 1) / len(plan))
    return {
        "rows": rows,
        **provenance.stamp("sensitivity", args, subject, subject.config),
    }


def main(args: SensitivityArgs) -> None:
    """The command."""
    subject = named.load(args.policy)
    tried(subject, args)  # before minutes of work
    files.make_folder("--out", args.out)
    console = Console()
    backend.begin(subject.config, args.engine)
    with screen.bars(console) as tell:
        result = sensitivity(subject, args, tell)
    files.write_json(args.out / "sensitivity.json", result)
    title = f"{args.policy}, {args.engine}: what its results owe to the physics' settings"
    picture.draw(result, title, args.out / "sensitivity.png")
    _print(console, args.policy, result["rows"])
    console.print(f"sensitivity.json and sensitivity.png in {args.out}", highlight=False)


def _print(console: Console, name: str, rows: list[dict[str, Any]]) -> None:
    table = Table("setting (* own)", *one_change.COLUMNS, title=name, box=box.SIMPLE)
    for row in rows:
        setting = f"{row['parameter']} {row['value']:g}{'*' if row['own'] else ''}"
        table.add_row(setting, *one_change.cells(row))
    console.print(table)
