"""``jaxwalk generalise`` from its options to its files."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

from rich import box
from rich.console import Console
from rich.table import Table

from jaxwalk.common import files
from jaxwalk.common.errors import UserError
from jaxwalk.config import Config
from jaxwalk.learn.policies import named
from jaxwalk.learn.policies.named import Subject
from jaxwalk.measure import one_change, study
from jaxwalk.measure.compare import policies
from jaxwalk.measure.evaluate import evaluation
from jaxwalk.measure.evaluate.evaluation import Programs
from jaxwalk.measure.generalise import picture
from jaxwalk.measure.generalise.circumstances import Circumstance, circumstances
from jaxwalk.measure.generalise.options import NOBODY
from jaxwalk.measure.protocol import PushTest
from jaxwalk.measure.screen import OnProgress

if TYPE_CHECKING:
    from jaxwalk.measure.generalise.options import GeneraliseArgs

Plan = list[tuple[Circumstance, Subject]]


def planned(args: GeneraliseArgs) -> Plan:
    """Who is measured in which circumstance, the policy first, then the one beside it.

    Raises:
      UserError: a policy that cannot be loaded, a circumstance that it cannot walk in, or another world
        beside it.
    """
    first = named.load(args.policy)
    tried = circumstances(first.config, args.values())
    if not tried:
        raise UserError(
            f"--only motor_strength: the motors of {args.policy} have no strength that could be less; "
            "give others"
        )
    names = [args.policy] + [args.beside] * (args.beside not in (NOBODY, args.policy))
    plan = [(one, one.subject(name)) for name in names for one in tried]
    own = next(place for place, one in enumerate(tried) if one.own)
    for _, other in plan[own :: len(tried)]:
        policies.check_world(plan[own][1], other)
    return plan


def generalise(plan: Plan, test: PushTest, progress: OnProgress = lambda what, share: None) -> dict[str, Any]:
    """The same trials in every circumstance.

    Sizes, noise, speed and burdens are numbers of the walkers: one program serves a policy.
    """
    programs, own = Programs(test), first(plan).config
    known: dict[str, dict[str, Any]] = {}  # a policy's own circumstance is among each kind's
    rows = []
    for place, (one, subject) in enumerate(plan):
        if not one.own or subject.name not in known:
            found = _measured(one, subject, test, own, programs)
            known |= {subject.name: found} if one.own else {}
        else:
            found = known[subject.name]
        what = {"policy": subject.name, "kind": one.kind, "value": one.value, "own": one.own}
        rows.append(what | found)
        progress("circumstances", (place + 1) / len(plan))
    return {"rows": rows}


def first(plan: Plan) -> Subject:
    """The policy under its own circumstance."""
    return next(subject for one, subject in plan if one.own)


def _measured(
    one: Circumstance, subject: Subject, test: PushTest, own: Config, programs: Programs
) -> dict[str, Any]:
    ratio = one.push_ratio(own)
    scaled = dataclasses.replace(test, impulses=tuple(ratio * impulse for impulse in test.impulses))
    row = one_change.measured(
        evaluation.evaluate(subject, scaled, programs=programs, burden=one.burden), test
    )
    return {
        "height": one.height,
        "mass": one.mass,
        "mass_total": one.kilograms,
        "speed_desired": one.speed,
        **row,
        "speed_ratio": row["walking"]["speed_mean"] / one.speed,
        "threshold_per_kg": {
            way: None if size is None else size / one.kilograms for way, size in row["threshold"].items()
        },
    }


def table(rows: list[dict[str, Any]]) -> bytes:
    """``generalise.csv``: a line for each policy and circumstance."""
    lines = []
    for row in rows:
        plain = ("policy", "kind", "value", "own", "height", "mass", "mass_total", "speed_desired")
        line = {name: row[name] for name in plain}
        for name in ("never_fell", "pushes_survived"):
            line |= {name: row[name]["share"]} | {f"{name}_{end}": row[name][end] for end in ("low", "high")}
        line |= {name: row["walking"][name] for name in ("speed_mean", "speed_std")}
        line |= {"speed_ratio": row["speed_ratio"], "step_length": row["walking"]["step_length_mean"]}
        for name in ("threshold", "threshold_per_kg"):
            line |= {f"{name}_{way}": size for way, size in row[name].items()}
        lines.append(line)
    return files.to_csv(lines)


def main(args: GeneraliseArgs) -> None:
    """Run ``jaxwalk generalise``."""
    plan = planned(args)  # before minutes of work
    subject = first(plan)
    study.carry_out(
        "generalise",
        args,
        subject.config,
        subject,
        lambda progress: generalise(plan, PushTest.of(args), progress),
        lambda console, result: _print(console, result["rows"]),
        picture.draw,
        lambda result: table(result["rows"]),
    )


def _print(console: Console, rows: list[dict[str, Any]]) -> None:
    for name in dict.fromkeys(row["policy"] for row in rows):
        columns = ("(* own)", *one_change.COLUMNS, "N s/kg", "asked")
        title = f"{name} (asked: speed / speed asked for; N s+: or more, the grid ends)"
        screen = Table(*columns, title=title, box=box.SIMPLE, padding=0, pad_edge=False)
        for row in (row for row in rows if row["policy"] == name):
            what = f"{row['kind'].replace('_', ' ')} {row['value']:g}{'*' if row['own'] else ''}"
            each = ("-" if size is None else f"{size:.2f}" for size in row["threshold_per_kg"].values())
            screen.add_row(what, *one_change.cells(row), "/".join(each), f"{row['speed_ratio']:.2f}")
        console.print(screen)
