"""How far the torso rocks in normal walking."""

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
from jaxwalk.paper.verdict import Check, below, mean_of, told

LIMIT = 0.1  # rad
SHOWN = 1000  # ticks in the figure


def measure(lab: Lab, model: BodyModel) -> Numbers:
    trace = lab.trace(model)
    swings, means, largest, example = [], [], 0.0, []
    for walker in range(len(trace.pitch)):
        ends, pitch = landings(trace, walker), trace.pitch[walker]
        if trace.fell[walker].any() or len(ends) < 3:
            continue
        ranges = [float(np.ptp(pitch[a:b])) for a, b in itertools.pairwise(ends)]
        swings.append(float(np.mean(ranges)))
        largest = max(largest, *ranges)
        means.append(float(pitch[ends[0] : ends[-1]].mean()))
        example = example or pitch[:SHOWN].astype(float).round(5).tolist()
    return {
        "swing": mean_of(swings),
        "largest": largest,
        "mean": mean_of(means),
        "timestep": lab.timestep(model),
        "example": example,
    }


def checks(numbers: Numbers) -> tuple[Check, ...]:
    swing = numbers["swing"]
    return (
        Check(
            f"from the least to the greatest pitch of a step {told(swing)} rad (largest of all "
            f"{numbers['largest']:.3f}; half of it, the amplitude, {(swing['mean'] or 0) / 2:.3f}), around "
            f"{told(numbers['mean'])} rad",
            below(swing, LIMIT),
        ),
    )


def table(numbers: Numbers) -> list[dict[str, float]]:
    dt = numbers["timestep"]
    return [{"seconds": round(i * dt, 4), "pitch": pitch} for i, pitch in enumerate(numbers["example"])]


def draw(numbers: Mapping[BodyModel, Numbers]) -> Figure:
    figure, axes = pictures.panels(1, len(numbers), width=4.8, sharey=True)
    for column, (body, one) in enumerate(numbers.items()):
        pitch, panel = np.array(one["example"]), axes[0, column]
        panel.plot(np.arange(len(pitch)) * one["timestep"], pitch, color=pictures.COLOURS[body])
        if len(pitch):
            middle = (pitch.max() + pitch.min()) / 2
            panel.axhspan(middle - LIMIT / 2, middle + LIMIT / 2, color="0.93", zorder=0, label="0.1 rad")
            panel.legend(frameon=False, fontsize=8)
        panel.set_xlabel("s")
    axes[0, 0].set_ylabel("torso pitch, rad")
    pictures.bodies(axes, numbers)
    return figure


CLAIM = Claim(
    name="pitch",
    title="The torso rocks by less than 0.1 rad",
    says="In normal walking the oscillation of the torso's pitch stays under 0.1 rad.",
    where="Fig. 7",
    rule="The range from the least to the greatest pitch of a step, averaged over steps, is under "
    f"{LIMIT:g} rad with all of its 95 % interval over walkers. (The stricter reading: an amplitude is "
    "half of that range.)",
    bodies=("planar", "walls"),
    quick=("planar", "walls"),
    measure=measure,
    checks=checks,
    table=table,
    draw=draw,
)
