"""``jaxwalk compare`` from its options to its files."""

from __future__ import annotations

import dataclasses
from itertools import combinations
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.table import Table

from jaxwalk.common import files
from jaxwalk.config import to_dict
from jaxwalk.measure import study
from jaxwalk.measure.compare import groups, picture, policies, verdicts
from jaxwalk.measure.compare.groups import Entry
from jaxwalk.measure.compare.policies import Member
from jaxwalk.measure.compare.verdicts import WAYS, Figures
from jaxwalk.measure.evaluate import evaluation
from jaxwalk.measure.protocol import PushTest
from jaxwalk.measure.screen import OnProgress

if TYPE_CHECKING:
    from jaxwalk.measure.compare.options import CompareArgs

# Figures on the terminal: title, of which figure, format.
_ROWS = (
    ("speed, m/s", "speed", ".3f"),
    ("unpushed survival", "survival_unpushed", ".0%"),
    ("recovery, s", "recovery_seconds", ".2f"),
    ("training footsteps", "training_footsteps", ",.0f"),
    ("training, s", "training_seconds", ",.0f"),
)


Loaded = list[list[Member]]


def load(args: CompareArgs) -> tuple[list[Entry], Loaded]:
    """Who is compared, and the members of each.

    Raises:
      UserError: a policy that cannot be loaded, or that walks in another world than the first.
    """
    entries = groups.parse(args.policies)
    changes = {name: getattr(args, name) for name in ("speed", "height", "mass", "noise", "model")}
    return entries, policies.load(entries, **changes)


def compare(entries: list[Entry], loaded: Loaded, test: PushTest, progress: OnProgress) -> dict[str, Any]:
    """Everyone on the same pushes, and who beats whom."""
    programs = evaluation.Programs(test)

    def measured(member: Member) -> dict[str, Any]:
        def own(what: str, share: float) -> None:
            progress(f"{member.subject.name}, {what}", share)

        return evaluation.evaluate(member.subject, test, own, programs)

    results = [[measured(member) for member in members] for members in loaded]
    every = [result for group in results for result in group]
    impulses = every[0]["pushes"]["impulses"]
    shared = verdicts.common(impulses, every)
    entrants = []
    for one, members, group in zip(entries, loaded, results, strict=True):
        seeds = [
            verdicts.figures(result, shared, member.training)
            for member, result in zip(members, group, strict=True)
        ]
        details = [
            {
                "policy": member.subject.name,
                "policy_digest": member.subject.digest,
                "config": to_dict(member.subject.config),
                "figures": found,
                "walking": result["walking"],
                "pushes": result["pushes"],
            }
            for member, found, result in zip(members, seeds, group, strict=True)
        ]
        entrants.append({"name": one.name, "spread": verdicts.spread(seeds), "members": details})
    reach = {
        way: max((sign * x for x in impulses if sign * x > 0), default=0.0)
        for way, sign in zip(WAYS, (1, -1), strict=True)
    }
    judged = [found for a, b in combinations(entrants, 2) if (found := verdicts.verdict(a, b, reach))]
    return {
        "impulses": impulses,
        "phases": every[0]["pushes"]["phases"],
        "reach": reach,
        "recovery_over": shared,
        "policies": entrants,
        "verdicts": [{**dataclasses.asdict(found), "sentence": verdicts.sentence(found)} for found in judged],
        "controllers_differ": policies.controllers_differ(loaded),
    }


def table(result: dict[str, Any]) -> bytes:
    """``compare.csv``: a line for each seed, and for each policy of several the figures over its seeds."""
    lines: list[dict[str, Any]] = []
    for policy in result["policies"]:
        for member in policy["members"]:
            lines.append({"name": policy["name"], "line": member["policy"], **member["figures"]})
        if len(policy["members"]) > 1:
            for what in ("mean", "sd", "min", "max"):
                over = {figure: values[what] for figure, values in policy["spread"].items()}
                lines.append({"name": policy["name"], "line": what, **over})
    return files.to_csv(lines)


def main(args: CompareArgs) -> None:
    """Run ``jaxwalk compare``."""
    entries, loaded = load(args)
    config = loaded[0][0].subject.config
    test = PushTest.of(args).sized(config, few=4)
    study.carry_out(
        "compare",
        dataclasses.replace(args, replicas=test.replicas),
        config,
        None,
        lambda progress: compare(entries, loaded, test, progress),
        _print,
        picture.draw,
        table,
    )


def _print(console: Console, result: dict[str, Any]) -> None:
    policies = result["policies"]
    replicas = result["options"]["replicas"]
    title = f"thresholds in N s, {replicas} walkers a cell (+: the grid ends); means over seeds"
    screen = Table("", *(policy["name"] for policy in policies), title=title)
    screen.add_row("seeds", *(str(len(policy["members"])) for policy in policies), end_section=True)

    def row(title: str, figure: str, form: str, reach: float = 0.0, last: bool = False) -> None:
        cells = (_told(policy["spread"][figure], form, reach) for policy in policies)
        screen.add_row(title, *cells, end_section=last)

    for where in ("worst_phase", "all_phases"):
        for way in WAYS:
            title = f"threshold {way}, {where.replace('_', ' ')}"
            row(title, f"{where}_{way}", ".4g", result["reach"][way])
    for title, figure, form in _ROWS:
        row(title, figure, form, last=figure == _ROWS[-1][1])
    for impulse in result["impulses"]:
        row(f"survival at {impulse:+g}", f"survival_{impulse:+g}", ".0%")
    console.print(screen)
    for line in result["controllers_differ"]:
        console.print(f"note: {line}", highlight=False)
    for verdict in result["verdicts"]:
        console.print(verdict["sentence"], highlight=False)


def _told(figure: Figures, form: str, reach: float = 0.0) -> str:
    """Mean (least to most) of the seeds; + where one survived the largest impulse of the grid."""
    mean, least, most = figure["mean"], figure["min"], figure["max"]
    if mean is None or least is None or most is None:
        return "-"
    more = "+" if verdicts.ends(figure, reach) else ""
    return f"{mean:{form}}{more}" + (f" ({least:{form}} to {most:{form}})" if least != most else "")
