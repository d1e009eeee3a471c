"""The average speed, and where in the step it is highest."""

from __future__ import annotations

import itertools
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
LAST = 0.8  # share of the step from which "just before touch-down" counts
PLACES = 25  # of the step, at which the mean course is told


def measure(lab: Lab, model: BodyModel) -> Numbers:
    trace = lab.trace(model)
    speeds, late, courses = [], [], []
    for walker in range(len(trace.velocity)):
        ends = landings(trace, walker)
        if trace.fell[walker].any() or len(ends) < 3:
            continue
        speed = trace.velocity[walker]
        steps = [speed[a:b] for a, b in itertools.pairwise(ends)]
        speeds.append(float(speed[ends[0] : ends[-1]].mean()))  # whole steps
        late.append(float(np.mean([step.argmax() / len(step) >= LAST for step in steps])))
        places = np.linspace(0, 1, PLACES)
        courses += [np.interp(places, np.linspace(0, 1, len(step)), step) for step in steps]
    courses = np.array(courses).reshape(-1, PLACES)
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
            f"share of steps that are fastest in their last fifth: {told(late, '.2f')}, of "
            f"{numbers['steps']} steps",
            above(late, 0.5),
        ),
    )


def table(numbers: Numbers) -> list[dict[str, float]]:
    course = numbers["course"]
    rows = zip(np.linspace(0, 1, PLACES), course["mean"], course["low"], course["high"], strict=False)
    return [
        {"share_of_step": round(float(x), 4), "speed": m, "tenth": low, "ninetieth": high}
        for x, m, low, high in rows
    ]


def draw(numbers: Mapping[BodyModel, Numbers]) -> Figure:
    figure, axes = pictures.panels(1, len(numbers), sharey=True)
    for column, (body, one) in enumerate(numbers.items()):
        course, panel, colour = one["course"], axes[0, column], pictures.COLOURS[body]
        x = np.linspace(0, 1, PLACES)[: len(course["mean"])]
        panel.fill_between(x, course["low"], course["high"], color=colour, alpha=0.2, linewidth=0)
        panel.plot(x, course["mean"], color=colour)
        if one["speed"]["mean"] is not None:
            panel.axhline(one["speed"]["mean"], color=pictures.GREY, linestyle="--", linewidth=1)
        panel.axvspan(LAST, 1, color="0.95", zorder=0)
        panel.set_xlabel("share of the step, touch-down to touch-down")
    axes[0, 0].set_ylabel("torso speed, m/s\n(band: 80 % of steps; dashes: mean)")
    pictures.bodies(axes, numbers)
    return figure


CLAIM = Claim(
    name="speed",
    title="Walks at about 1 m/s, fastest just before touch-down",
    says="The biped “can walk at a steady pace of approximately 1 m/s”; its speed oscillates within each "
    "step and is highest just before touch-down.",
    where="abstract; Fig. 6",
    rule=f"The mean over walkers lies within {ABOUT:g} m/s of 1 with all of its 95 % interval, and more "
    "than half of the steps have their fastest moment in the last fifth of the step, again with all of "
    "the interval.",
    bodies=("planar", "walls"),
    quick=("planar", "walls"),
    measure=measure,
    checks=checks,
    table=table,
    draw=draw,
)
