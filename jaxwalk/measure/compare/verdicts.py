"""What the trials of a comparison say: figures of each seed, of each policy, and who beats whom."""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from jaxwalk.measure.survival import SURVIVED

WAYS = ("forward", "backward")
Figures = dict[str, int | float | None]


def common(impulses: Sequence[float], results: Sequence[Mapping[str, Any]]) -> list[float]:
    """The impulses that every one of ``jaxwalk evaluate``'s ``results`` survives: where times compare."""
    return [
        impulse
        for i, impulse in enumerate(impulses)
        if all(_mean(result["pushes"]["survival"][i]) >= SURVIVED for result in results)
    ]


def figures(
    result: Mapping[str, Any], shared: Sequence[float], training: Mapping[str, int | float | None]
) -> Figures:
    """The figures of one seed, in the order in which they are shown; None where there is none.

    Args:
      result: of ``jaxwalk evaluate``.
      shared: impulses over which recovery is averaged, since who survives more has harder cases to show.
      training: footsteps and seconds.
    """
    walking, pushes = result["walking"], result["pushes"]
    impulses = pushes["impulses"]
    times = [
        time
        for impulse, row in zip(impulses, pushes["recovery_seconds"], strict=True)
        if impulse in shared
        for time in row
        if time is not None
    ]
    found: Figures = {"speed": walking["speed_mean"], "survival_unpushed": walking["survival"]}
    found |= {f"worst_phase_{way}": result["threshold_worst_phase"][way] for way in WAYS}
    found |= {f"all_phases_{way}": result["threshold"][way] for way in WAYS}
    found["recovery_seconds"] = _mean(times) if times else None
    for impulse, row in zip(impulses, pushes["survival"], strict=True):
        found[f"survival_{impulse:+g}"] = _mean(row)
    for impulse, row in zip(impulses, pushes["survival"], strict=True):
        found[f"survival_worst_phase_{impulse:+g}"] = min(row)
    return found | {f"training_{what}": value for what, value in training.items()}


def spread(seeds: Sequence[Figures]) -> dict[str, Figures]:
    """Mean, sd (of the sample; None for one), min and max of each figure over the seeds that have it."""
    found = {}
    for name in seeds[0]:
        values = [x for x in (one[name] for one in seeds) if x is not None]
        found[name] = {
            "mean": _mean(values) if values else None,
            "sd": statistics.stdev(values) if len(values) > 1 else None,
            "min": min(values, default=None),
            "max": max(values, default=None),
        }
    return found


@dataclass(frozen=True)
class Verdict:
    """Whether one policy stands harder pushes than another at the worst phase of the step.

    Attributes:
      better, worse: names; where neither wins both ways, in the order given.
      kind: ``undecided``: in some direction all seeds of both stand the largest push of the grid.
        ``beats``: higher in every direction tried. ``alike``: equal in all. ``mixed``: anything else.
      thresholds: of each direction tried: of the better and the worse one, means over seeds, N s.
      censored: likewise, whether the grid ended before a seed fell: the threshold is that "or more".
      every_seed: ``beats``, and the worst seed of one is above the best of the other, in every direction.
    """

    better: str
    worse: str
    kind: str
    thresholds: dict[str, tuple[float, float]]
    censored: dict[str, tuple[bool, bool]]
    every_seed: bool


def ends(figure: Figures, reach: float) -> bool:
    """Whether a seed stands ``reach``, the largest push that was tried, N s: its threshold may be larger."""
    return figure["max"] is not None and 0 < reach <= figure["max"]


def verdict(a: Mapping[str, Any], b: Mapping[str, Any], reach: Mapping[str, float]) -> Verdict | None:
    """The rule: A beats B if its mean threshold at the worst phase is higher in every direction tried.

    Args:
      a, b: ``name`` and ``spread`` of each.
      reach: largest impulse tried each way, N s.

    Returns:
      None where no push was tried.
    """
    sides = {}
    for way in WAYS:
        one, other = (x["spread"][f"worst_phase_{way}"] for x in (a, b))
        if one["mean"] is not None and other["mean"] is not None:
            sides[way] = one, other
    if not sides:
        return None
    signs = {(one["mean"] > other["mean"]) - (one["mean"] < other["mean"]) for one, other in sides.values()}
    if signs == {-1}:
        return verdict(b, a, reach)
    if any(0 < reach[way] <= min(one["min"], other["min"]) for way, (one, other) in sides.items()):
        kind = "undecided"
    else:
        kind = "beats" if signs == {1} else "alike" if signs == {0} else "mixed"
    return Verdict(
        better=a["name"],
        worse=b["name"],
        kind=kind,
        thresholds={way: (one["mean"], other["mean"]) for way, (one, other) in sides.items()},
        censored={
            way: (ends(one, reach[way]), ends(other, reach[way])) for way, (one, other) in sides.items()
        },
        every_seed=kind == "beats" and all(one["min"] > other["max"] for one, other in sides.values()),
    )


def sentence(found: Verdict) -> str:
    """A verdict in words; + marks what is censored."""

    def told(way: str, which: int) -> str:
        return f"{found.thresholds[way][which]:.4g}{'+' if found.censored[way][which] else ''}"

    sizes = ", ".join(
        f"{way} {told(way, 0)} against {told(way, 1)} N s ({one - other:+.3g})"
        for way, (one, other) in found.thresholds.items()
    )
    both = "in both directions" if len(found.thresholds) == 2 else "in the direction tried"
    if found.kind == "beats":
        seeds = "every seed" if found.every_seed else "not every seed"
        return f"{found.better} beats {found.worse} at the worst phase {both} ({seeds}): {sizes}"
    if found.kind == "undecided":
        return f"{found.better} and {found.worse}: the grid ends before both fall at the worst phase: {sizes}"
    if found.kind == "alike":
        return f"{found.better} and {found.worse} are alike at the worst phase: {sizes}"
    return f"neither {found.better} nor {found.worse} beats the other at the worst phase {both}: {sizes}"


def _mean(values: Sequence[int | float]) -> float:
    return sum(values) / len(values)
