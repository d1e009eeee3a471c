"""The two pushes of the paper, at several points of the body."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from jaxwalk.config import BodyModel
from jaxwalk.paper import pictures
from jaxwalk.paper.claim import Claim, Numbers
from jaxwalk.paper.lab import Lab
from jaxwalk.paper.verdict import Check, above, percent, share

IMPULSES = (30.0, -40.0)  # N s; on the back, on the front
POINTS = ("torso", "torso+0.2", "torso-0.2", "stance-thigh", "swing-thigh")
WITHIN = 5.0  # s
MOST = 0.9


def measure(lab: Lab, model: BodyModel) -> Numbers:
    subject, sample = lab.subject(model), lab.sample(model)
    phases = [p / sample.phases for p in range(sample.phases)]
    grid = [(i, point, p) for i in IMPULSES for point in POINTS for p in phases] * sample.replicas
    impulse, phase = np.array([g[0] for g in grid]), np.array([g[2] for g in grid])
    scenario = lab.scenarios(subject, impulse, phase, point=[g[1] for g in grid])
    found = lab.pushed(subject, scenario, lab.profile(subject, model))
    steady = found["up"] & (found["recovery"] <= WITHIN)
    point = np.array([g[1] for g in grid])
    rows = []
    for size in IMPULSES:
        for name in POINTS:
            here = (impulse == size) & (point == name)
            seconds = found["recovery"][here & steady]
            rows.append(
                {
                    "impulse": size, "point": name,
                    "up": share(found["up"][here]), "steady": share(steady[here]),
                    "longest": float(seconds.max()) if len(seconds) else None,
                }
            )  # fmt: skip
    return {
        "rows": rows,
        "all": {f"{size:+g}": share(steady[impulse == size]) for size in IMPULSES},
    }


def checks(numbers: Numbers) -> tuple[Check, ...]:
    words = {"+30": "30 N s on the back", "-40": "40 N s on the front"}
    out = []
    for size, told in numbers["all"].items():
        here = [row for row in numbers["rows"] if f"{row['impulse']:+g}" == size]
        longest = max((row["longest"] for row in here if row["longest"] is not None), default=None)
        after = "" if longest is None else f", the slowest of them after {longest:.1f} s"
        out.append(
            Check(
                f"{words[size]}: up and steady within {WITHIN:g} s {percent(told)}{after}", above(told, MOST)
            )
        )
    return tuple(out)


def table(numbers: Numbers) -> list[dict[str, object]]:
    return [
        {
            "impulse": row["impulse"], "point": row["point"],
            **{f"{what}_{k}": v for what in ("up", "steady") for k, v in row[what].items()},
            "longest_seconds": row["longest"],
        }
        for row in numbers["rows"]
    ]  # fmt: skip


def draw(numbers: Mapping[BodyModel, Numbers]) -> Figure:
    figure, axes = pictures.panels(1, len(numbers), width=4.8, sharey=True)
    for column, one in enumerate(numbers.values()):
        panel = axes[0, column]
        steady = {(row["impulse"], row["point"]): row["steady"] for row in one["rows"]}
        for offset, size, colour in ((-0.2, 30.0, pictures.BLUE), (0.2, -40.0, pictures.ORANGE)):
            for place, name in enumerate(POINTS):
                pictures.bar(panel, place + offset, steady[size, name], colour, 0.36)
            panel.bar(0, 0, color=colour, label="30 N s, back" if size > 0 else "40 N s, front")
        panel.set_xticks(range(len(POINTS)), POINTS, rotation=25, ha="right", fontsize=8)
        pictures.shares(panel)
    axes[0, 0].set_ylabel(f"up and steady within {WITHIN:g} s, share")
    pictures.legend(figure, axes[0, 0])
    pictures.bodies(axes, numbers)
    return figure


CLAIM = Claim(
    name="pushes",
    title="Survives 30 N s on the back and 40 N s on the front",
    says="It “can maintain stability with a 30 kg·m/s impulse applied forward on the torso or a 40 kg·m/s "
    "impulse applied rearward”, for 0.1 s, at different points of the body, and is steady again in under "
    "5 s.",
    where="abstract; Fig. 6",
    rule="Of each of the two pushes, over several points of the body and all phases of the step, more "
    f"than {100 * MOST:g} % end up and steady within {WITHIN:g} s, with all of the 95 % interval. Steady: "
    "a whole step long within 0.1 m/s of the unpushed walk's speed at the same moment of the step.",
    bodies=("planar", "walls"),
    quick=("planar", "walls"),
    measure=measure,
    checks=checks,
    table=table,
    draw=draw,
)
