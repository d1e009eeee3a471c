"""Speed against robustness: the desired speed and the ankle's damping, swept."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from matplotlib.figure import Figure

from jaxwalk.config import BodyModel
from jaxwalk.paper import pictures
from jaxwalk.paper.claim import Claim, Numbers
from jaxwalk.paper.lab import Lab, changed
from jaxwalk.paper.verdict import Check, above, below, slope, told

# Every damping is a program of its own, a desired speed is not.
SPEEDS = {False: (0.7, 0.85, 1.0, 1.15, 1.3), True: (0.8, 1.0, 1.2)}  # m/s
DAMPINGS = {False: (0.25, 0.5, 1.0, 2.0, 4.0), True: (0.25, 4.0)}  # N m s/rad
KINDS = ("desired speed", "ankle damping")
_KEPT = ("calm", "pushed", "speed", "speeds", "survived")


def measure(lab: Lab, model: BodyModel) -> Numbers:
    subject, few = lab.subject(model), lab.quick or model == "walls"
    own = subject.config.physics.ankle_damping
    found: dict[str, dict[str, Any]] = {kind: {} for kind in KINDS}
    for speed in SPEEDS[few]:
        exam = lab.exam(
            subject, model, changed(subject.config.gait, speed_desired=speed), f"v_desire {speed:g}"
        )
        found[KINDS[0]][f"{speed:g}"] = {name: exam[name] for name in _KEPT}
    for damping in sorted({*DAMPINGS[few], own}):
        physics = dataclasses.replace(subject.config.physics, ankle_damping=damping)
        config = dataclasses.replace(subject.config, physics=physics)
        exam = lab.exam(dataclasses.replace(subject, config=config), model, what=f"damping {damping:g}")
        found[KINDS[1]][f"{damping:g}"] = {name: exam[name] for name in _KEPT}
    return found


def _slopes(rows: Mapping[str, Any]) -> tuple[dict, dict]:
    speed = [(float(x), y) for x, row in rows.items() for y in row["speeds"]]
    up = [(float(x), y) for x, row in rows.items() for y in map(float, row["survived"])]
    return slope(*zip(*speed, strict=True)) if speed else slope([], []), slope(*zip(*up, strict=True))


def checks(numbers: Numbers) -> tuple[Check, ...]:
    out = []
    for kind, unit, faster, safer in (
        (KINDS[0], "m/s", above, below),
        (KINDS[1], "N m s/rad", below, above),
    ):
        speed, up = _slopes(numbers[kind])
        out += [
            Check(f"{kind}: speed changes by {told(speed)} m/s per {unit}", faster(speed)),
            Check(f"{kind}: share of pushes survived changes by {told(up)} per {unit}", safer(up)),
        ]
    return tuple(out)


def table(numbers: Numbers) -> list[dict[str, object]]:
    return [
        {
            "swept": kind, "value": float(value),
            **{f"{what}_{k}": v for what in ("speed", "calm", "pushed") for k, v in row[what].items()},
        }
        for kind in KINDS
        for value, row in numbers[kind].items()
    ]  # fmt: skip


def draw(numbers: Mapping[BodyModel, Numbers]) -> Figure:
    figure, axes = pictures.panels(2, 2, sharex="col", sharey="row")
    for column, kind in enumerate(KINDS):
        for body, one in numbers.items():
            colour, label = pictures.COLOURS[body], pictures.BODIES[body]
            for i, (value, row) in enumerate(one[kind].items()):
                pictures.point(axes[0, column], float(value), row["speed"], colour, label if i == 0 else None)
                pictures.point(axes[1, column], float(value), row["pushed"], colour)
        pictures.shares(axes[1, column])
        values = sorted({float(value) for one in numbers.values() for value in one[kind]})
        axes[1, column].set_xscale("log")
        axes[1, column].set_xticks(values, [f"{value:g}" for value in values])
        axes[1, column].minorticks_off()
        pictures.title(axes[0, column], kind)
    axes[0, 0].set_ylabel("speed, m/s")
    axes[1, 0].set_ylabel("graded pushes survived, share")
    axes[1, 0].set_xlabel("v_desire, m/s")
    axes[1, 1].set_xlabel("ankle damping c, N m s/rad")
    pictures.legend(figure, axes[0, 0])
    return figure


CLAIM = Claim(
    name="trade",
    title="More desired speed or less ankle damping: faster and less robust",
    says="A higher v_desire or a lower ankle damping makes the walker faster and less robust.",
    where="discussion; eqs 14-22",
    rule="With the policy frozen, the lines through all walkers say that speed rises and the share of "
    "pushes survived falls with v_desire, and that speed falls and that share rises with the ankle's "
    "damping: four signs, each with all of its 95 % interval.",
    bodies=("planar", "walls"),
    quick=("planar",),
    measure=measure,
    checks=checks,
    table=table,
    draw=draw,
)
