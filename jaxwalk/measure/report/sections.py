"""What each part's numbers say, in sentences and tables. No verdict is written by hand."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from jaxwalk.measure.compare.verdicts import WAYS
from jaxwalk.measure.report import generalised, measured
from jaxwalk.measure.report.options import Name
from jaxwalk.measure.report.words import (
    NOTHING,
    Section,
    Table,
    both_ways,
    impulse,
    interval,
    number,
    percent,
    place,
    reach,
)
from jaxwalk.measure.survival import SURVIVED, pooled
from jaxwalk.model.push_points import Point

_MOST = f"{SURVIVED:.0%}".replace("%", " %")


def evaluate(result: dict[str, Any]) -> Section:
    """What the results of ``jaxwalk evaluate`` say."""
    walking, options = result["walking"], result["options"]
    walkers, replicas = options["walkers"], options["replicas"]
    up = pooled(round(walking["survival"] * walkers), walkers)
    sentences = [
        f"{up['survivors']} of {walkers} walkers walked {options['seconds']:g} s without a fall, "
        f"{interval(up)}, at {walking['speed_mean']:.3f} m/s (standard deviation between walkers "
        f"{walking['speed_std']:.3f}), in steps of {walking['step_length_mean']:.3f} m and "
        f"{walking['step_duration_mean']:.3f} s; {options['speed']:g} m/s was asked for."
    ]
    if "pushes" not in result:
        return Section(tuple(sentences), ())
    pushes, largest = result["pushes"], reach(result["pushes"]["impulses"])
    sentences.append(
        f"{_MOST} survive every push up to {both_ways(result['threshold'], largest)} over all phases of the "
        f"step, and up to {both_ways(result['threshold_worst_phase'], largest)} at the worst phase."
    )
    rows = []
    for size, survival, steady, recovery in zip(
        pushes["impulses"], pushes["survival"], pushes["steady"], pushes["recovery_seconds"], strict=True
    ):
        trials = len(survival) * replicas
        times = [time for time in recovery if time is not None]
        rows.append(
            (
                f"{size:+g}",
                interval(pooled(round(sum(survival) * replicas), trials)),
                percent(min(survival)),
                percent(float(np.mean(steady))),
                number(sum(times) / len(times) if times else None, ".2f"),
                number(max(times, default=None), ".2f"),
            )
        )
    header = (
        "push, N s", "survived (95 % interval)", "worst phase", "steady again", "mean time, s",
        "slowest phase, s",
    )  # fmt: skip
    caption = (
        f"Pushes of {options['push_duration']:g} s {place(options['push_height'])}, "
        f"{replicas} walkers at each of {options['phases']} phases. Times until steady, over those who were."
    )
    return Section(tuple(sentences), (Table(caption, header, tuple(rows)),))


def push_map(result: dict[str, Any]) -> Section:
    """What the results of ``jaxwalk push-map`` say."""
    phases, largest = result["phases"], reach(result["impulses"])
    limits, rows = [], []
    for d, duration in enumerate(result["durations"]):
        for p, point in enumerate(result["points"]):
            part, where = result["maps"][d][p], f"{duration:g} s, {point}"
            for way in WAYS:
                limits.append(_limit(part, phases, f"{way}, {where}", way))
            for size, survival in zip(result["impulses"], part["survival"], strict=True):
                count = len(survival) * result["replicas"]
                up = pooled(round(sum(survival) * result["replicas"]), count)
                rows.append((where, f"{size:+g}", interval(up), percent(min(survival))))
    first = result["maps"][0][0]
    sizes = {
        which: {
            way: None if (one := first["threshold"][which][way]) is None else one["impulse"] for way in WAYS
        }
        for which in ("all_phases", "worst_phase")
    }
    sentences = (
        f"{result['trials']:,} trials: {len(result['impulses'])} impulses at {len(phases)} phases of the "
        f"step x {result['replicas']} walkers. Lines: thresholds by phase, and the limits of a linear "
        "pendulum of the same body (A: the step in flight fixed, B: re-planned at once, C: no step back).",
        f"Of pushes of {result['durations'][0]:g} s on the {Point.of(result['points'][0]).words}, "
        f"{_MOST} survive up to {both_ways(sizes['all_phases'], largest)} over all phases, and up to "
        f"{both_ways(sizes['worst_phase'], largest)} at the worst phase.",
    )
    limit = Table(
        "Thresholds (+: the grid ends there), and the least share of the pendulum's limit that a phase "
        "reaches: of B forward, of C backward.",
        ("push", "all phases, N s", "N s/kg", "worst phase, N s", "N s/kg", "worst at phase", "of the limit"),
        tuple(limits),
    )
    survived = Table(
        "Survival over all phases and at the worst one.",
        ("push", "impulse, N s", "survived (95 % interval)", "worst phase"), tuple(rows),
    )  # fmt: skip
    return Section(sentences, (limit, survived))


def _limit(part: dict[str, Any], phases: list[float], name: str, way: str) -> tuple[str, ...]:
    cells: list[str] = []
    for which in ("all_phases", "worst_phase"):
        one = part["threshold"][which][way]
        plus = "+" if one and one["censored"] else ""
        cells += [NOTHING, NOTHING] if one is None else [f"{one['impulse']:g}{plus}", f"{one['per_kg']:.2f}"]
    worst, each = part["threshold"]["worst_phase"][way], part["threshold"]["each_phase"]
    at = [
        f"{phase:.3g}"
        for phase, one in zip(phases, each, strict=True)
        if worst is not None and one[way]["impulse"] == worst["impulse"]
    ]
    limited = part["share_of_limit"] or {way: []}  # the pendulum knows no legs
    shares = [share for share in limited[way] if share is not None]
    where = "all" if len(at) == len(phases) else ", ".join(at) or NOTHING
    return (name, *cells, where, number(min(shares, default=None), ".2f"))


def compare(result: dict[str, Any]) -> Section:
    """What the results of ``jaxwalk compare`` say."""
    policies, largest = result["policies"], result["reach"]

    def mean(policy: dict[str, Any], figure: str) -> float | None:
        return policy["spread"][figure]["mean"]

    rows = tuple(
        (
            policy["name"],
            str(len(policy["members"])),
            number(mean(policy, "speed")),
            percent(policy["spread"]["survival_unpushed"]["mean"]),
            *(
                impulse(mean(policy, f"{where}_{way}"), largest[way])
                for where in ("all_phases", "worst_phase")
                for way in WAYS
            ),
            number(mean(policy, "recovery_seconds"), ".2f"),
        )
        for policy in policies
    )
    header = (
        "policy", "seeds", "speed, m/s", "never fell", "all phases, forward", "all phases, backward",
        "worst phase, forward", "worst phase, backward", "recovery, s",
    )  # fmt: skip
    over = ", ".join(f"{x:+g}" for x in result["recovery_over"]) or "none"
    summary = Table(
        "Means over seeds. Thresholds in N s (+: the grid ends there). Recovery: over the pushes that all "
        f"survive ({over} N s).",
        header,
        rows,
    )
    pushes = Table(
        "Survival of each push, over all phases.",
        ("push, N s", *(policy["name"] for policy in policies)),
        tuple(
            (f"{x:+g}", *(percent(policy["spread"][f"survival_{x:+g}"]["mean"]) for policy in policies))
            for x in result["impulses"]
        ),
    )
    members = sum(len(policy["members"]) for policy in policies)
    sentences = (
        f"{len(policies)} policies with {members} seeds in all, on the same starts, noise and pushes. One "
        "beats another if its mean threshold at the worst phase of the step is higher in every direction.",
    )
    points = *(one["sentence"] for one in result["verdicts"]), *result["controllers_differ"]
    return Section(sentences, (summary, pushes), points)


SECTIONS: dict[Name, Callable[[dict[str, Any]], Section]] = {
    "compare": compare,
    "evaluate": evaluate,
    "push-map": push_map,
    "generalise": generalised.generalise,
    "sensitivity": measured.sensitivity,
    "agreement": measured.agreement,
    "gait": measured.gait,
    "bench": measured.bench,
}
