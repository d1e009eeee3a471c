"""The average speed, and where in the step it is highest."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from jaxwalk.config import BodyModel
from jaxwalk.paper import pictures
from jaxwalk.paper.claim import Claim, Numbers
from jaxwalk.paper.lab import Lab
from jaxwalk.paper.trace import landings
from jaxwalk.paper.verdict import Check, above, mean_of, told, within

ABOUT = 0.1  # m/s either side of 1
LAST = 0.2  # share of the step before a touch-down that counts as just before it
SENSED = 0.01  # s after which a touch-down is sensed at the latest: the sole must bear a force first
PLACES = np.linspace(-0.5, 0.5, 41)  # shares of the step around touch-down, at which the mean course is told


def measure(lab: Lab, model: BodyModel) -> Numbers:
    trace, sensed = lab.trace(model), round(SENSED / lab.timestep(model))
    speeds, late, courses = [], [], []
    for walker in range(len(trace.velocity)):
        ends = landings(trace, walker)
        if trace.fell[walker].any() or len(ends) < 3:
            continue
        speed = trace.velocity[walker]
        speeds.append(float(speed[ends[0] : ends[-1]].mean()))  # whole steps
        just = []
        for before, here, after in zip(ends[:-2], ends[1:-1], ends[2:], strict=True):
            length = here - before
            begin = here - length // 2
            fastest = begin + int(speed[begin : (here + after) // 2].argmax()) - here
            just.append(-LAST * length <= fastest <= sensed)
            courses.append(np.interp(here + PLACES * length, np.arange(len(speed)), speed))
        late.append(float(np.mean(just)))
    courses = np.array(courses).reshape(-1, len(PLACES))
    low, mean, high = (
        (np.quantile(courses, 0.1, axis=0), courses.mean(0), np.quantile(courses, 0.9, axis=0))
        if len(courses)
        else (np.zeros(0),) * 3
    )
    return {
        "speed": mean_of(speeds),
        "late": mean_of(late),
        "steps": len(courses),
        "course": {
            "mean": mean.round(4).tolist(),
            "low": low.round(4).tolist(),
            "high": high.round(4).tolist(),
        },
    }


def checks(numbers: Numbers) -> tuple[Check, ...]:
    speed, late = numbers["speed"], numbers["late"]
    return (
        Check(f"average speed {told(speed)} m/s", within(speed, 1 - ABOUT, 1 + ABOUT)),
        Check(
            f"share of touch-downs just before which a step is fastest: {told(late, '.2f')}, of "
            f"{numbers['steps']} steps",
            above(late, 0.5),
        ),
    )


def table(numbers: Numbers) -> list[dict[str, float]]:
    course = numbers["course"]
    rows = zip(PLACES, course["mean"], course["low"], course["high"], strict=False)
    return [
        {"share_of_step_from_touch_down": round(float(x), 4), "speed": m, "tenth": low, "ninetieth": high}
        for x, m, low, high in rows
    ]


def draw(numbers: Mapping[BodyModel, Numbers]) -> Figure:
    figure, axes = pictures.panels(1, len(numbers), sharey=True)
    for column, (body, one) in enumerate(numbers.items()):
        course, panel, colour = one["course"], axes[0, column], pictures.COLOURS[body]
        x = PLACES[: len(course["mean"])]
        panel.fill_between(x, course["low"], course["high"], color=colour, alpha=0.2, linewidth=0)
        panel.plot(x, course["mean"], color=colour)
        if one["speed"]["mean"] is not None:
            panel.axhline(one["speed"]["mean"], color=pictures.GREY, linestyle="--", linewidth=1)
        panel.axvspan(-LAST, 0, color="0.95", zorder=0)
        panel.set_xlabel("share of the step, from touch-down")
    axes[0, 0].set_ylabel("torso speed, m/s\n(band: 80 % of steps; dashes: mean)")
    pictures.bodies(axes, numbers)
    return figure


CLAIM = Claim(
    name="speed",
    title="Walks at about 1 m/s, fastest just before touch-down",
    says="The biped “can walk at a steady pace of approximately 1 m/s”; its speed oscillates within each "
    "step and is highest just before touch-down.",
    where="abstract; Fig. 6",
    rule=f"The mean over walkers lies within {ABOUT:g} m/s of 1 with all of its 95 % interval, and at more "
    "than half of the touch-downs, again with all of the interval, the fastest moment from half a step "
    f"before to half a step after lies in the last fifth before it or within the {1000 * SENSED:g} ms in "
    "which a touch-down is sensed.",
    bodies=("planar", "walls"),
    quick=("planar", "walls"),
    measure=measure,
    checks=checks,
    table=table,
    draw=draw,
)
