"""One policy, carried over unchanged: in the plane, and on the paper's body between two walls."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from jaxwalk.config import BodyModel
from jaxwalk.learn.policies import named
from jaxwalk.measure.survival import SURVIVED, threshold
from jaxwalk.paper import pictures
from jaxwalk.paper.claim import BODIES, Claim, Numbers
from jaxwalk.paper.lab import Lab, speeds_of
from jaxwalk.paper.verdict import Check, mean_of, share, told, within
from jaxwalk.task import scenarios, trials

IMPULSES = {
    False: (-100.0, -80.0, -60.0, -40.0, 30.0, 50.0, 70.0, 80.0),
    True: (-80.0, -40.0, 30.0, 70.0),
}  # N s
LEAST = {"forward": 30.0, "backward": 40.0}  # N s, the paper's pushes
SECONDS = 10.0


def measure(lab: Lab, model: BodyModel) -> Numbers:
    subject, sample = named.load(lab.policy, model=model), lab.sample(model)
    none = np.zeros(sample.walkers)
    calm = lab.trial(subject, lab.scenarios(subject, none, none, scenarios.CALM), SECONDS, what="walking")
    tally, up = calm.tally, trials.survived(calm)
    steps = np.maximum(np.asarray(tally.steps), 1.0)
    impulses = IMPULSES[lab.quick]
    grid = [(i, p / sample.phases) for i in impulses for p in range(sample.phases)] * sample.replicas
    impulse, phase = np.array(grid).T
    survived = lab.pushed(subject, lab.scenarios(subject, impulse, phase), None)["up"]
    rows = [{"impulse": i, **share(survived[impulse == i])} for i in impulses]
    return {
        "speed": mean_of(speeds_of(calm, slice(None))),
        "length": mean_of((np.asarray(tally.step_length) / steps)[up]),
        "duration": mean_of((np.asarray(tally.step_seconds) / steps)[up]),
        "threshold": threshold(impulses, [row["mean"] for row in rows]),
        "rows": rows,
    }


def checks(numbers: Numbers) -> tuple[Check, ...]:
    walks = Check(
        f"speed {told(numbers['speed'])} m/s, step {told(numbers['length'])} m in "
        f"{told(numbers['duration'])} s",
        within(numbers["speed"], 0.9, 1.1),
    )
    stands = (
        Check(f"threshold {way} {size:g} N s", size >= LEAST[way])
        for way, size in numbers["threshold"].items()
    )
    return (walks, *stands)


def table(numbers: Numbers) -> list[dict[str, object]]:
    return numbers["rows"]


def draw(numbers: Mapping[BodyModel, Numbers]) -> Figure:
    figure, axes = pictures.panels(1, 1, width=7.0)
    for place, (body, one) in enumerate(numbers.items()):
        for row in one["rows"]:
            pictures.bar(
                axes[0, 0], row["impulse"] + 5 * (place - 0.5), row, pictures.COLOURS[body], width=4.5
            )
        axes[0, 0].plot([], [], color=pictures.COLOURS[body], label=BODIES[body])
    axes[0, 0].axhline(SURVIVED, color="0.6", linewidth=0.8, zorder=0)
    axes[0, 0].set_xlabel("impulse, N s")
    axes[0, 0].set_ylabel("survived, share")
    axes[0, 0].legend(frameon=False, fontsize=8)
    pictures.shares(axes[0, 0])
    return figure


CLAIM = Claim(
    name="bodies",
    title="What is learned in the plane carries over to the paper's body",
    says="(Not in the paper, whose walker is always between walls: what allows the other claims to be "
    "measured, and policies to be trained, in the plane.) It walks at about 1 m/s and takes 30 N s forward "
    "and 40 N s backward.",
    where="ours; bars of the abstract",
    rule="The same policy, unchanged, on each body: mean speed within 0.1 m/s of 1 with all of its 95 % "
    f"interval, thresholds of at least {LEAST['forward']:g} N s forward and {LEAST['backward']:g} backward. "
    f"Threshold: the largest impulse that, like every smaller one, {SURVIVED:.0%} of walkers survive, all "
    "phases of the step together.",
    bodies=("planar", "walls"),
    quick=("planar", "walls"),
    measure=measure,
    checks=checks,
    table=table,
    draw=draw,
)
