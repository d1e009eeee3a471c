"""Which step is chosen at which speed, and after which push."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from jaxwalk.config import BodyModel
from jaxwalk.paper import pictures
from jaxwalk.paper.claim import Claim, Numbers
from jaxwalk.paper.lab import Lab
from jaxwalk.paper.trace import Trace, landings
from jaxwalk.paper.verdict import Check, above, below, mean_of, slope, told

PUSHES = {"forward": 30.0, "backward": -40.0}  # N s, the paper's
CHOICES = ("length", "duration")
DIGITS = {"length": ".3f", "duration": ".4f"}
UNITS = {"length": "m", "duration": "s"}


def _decisions(trace: Trace, walker: int, answered: int) -> dict[str, np.ndarray]:
    """The tick of each touch-down, the speed there (as the policy is told), the length and duration chosen.

    Args:
      answered: ticks after a touch-down within which the policy has answered.
    """
    ends = landings(trace, walker)
    ends = ends[ends + answered < trace.elapsed.shape[1]]
    return {
        "tick": ends,
        "speed": np.asarray(trace.filtered[walker, ends, 0]),
        "length": np.asarray(trace.length[walker, ends + answered]),
        "duration": np.asarray(trace.duration[walker, ends + answered]),
    }


def measure(lab: Lab, model: BodyModel) -> Numbers:
    answered = lab.subject(model).config.train.window_ticks + 1
    slopes: dict[str, list[float | None]] = {name: [] for name in CHOICES}
    changes: dict[str, dict[str, list[float]]] = {way: {name: [] for name in CHOICES} for way in PUSHES}
    points = []
    for way, impulse in PUSHES.items():
        trace = lab.trace(model, impulse)
        for walker in range(len(trace.velocity)):
            found = _decisions(trace, walker, answered)
            pushed = np.flatnonzero(trace.pushing[walker])
            if not len(pushed):
                continue
            before, after = found["tick"] < pushed[0], found["tick"] > pushed[-1]
            usual = before & (found["tick"] * lab.timestep(model) > 1.5)  # the start is over
            if usual.sum() < 2 or not after.any():
                continue
            late = usual | after
            for name in CHOICES:
                slopes[name].append(slope(found["speed"][late], found[name][late])["mean"])
                answer = found[name][after][0] - found[name][usual].mean()
                changes[way][name].append(float(answer))
            kinds = np.where(usual, "before", "later")
            kinds[np.flatnonzero(after)[0]] = "first"
            points += [
                {
                    "walker": walker, "push": way, "when": str(kinds[i]),
                    **{n: round(float(found[n][i]), 4) for n in ("speed", *CHOICES)},
                }
                for i in np.flatnonzero(late)
            ]  # fmt: skip
    return {
        "slopes": {name: mean_of([x for x in each if x is not None]) for name, each in slopes.items()},
        "changes": {way: {name: mean_of(each[name]) for name in CHOICES} for way, each in changes.items()},
        "points": points,
    }


def checks(numbers: Numbers) -> tuple[Check, ...]:
    asked = {"length": above, "duration": below}
    out = [
        Check(
            f"{name} against speed: slope {told(numbers['slopes'][name], DIGITS[name])} {UNITS[name]} per "
            "m/s",
            asked[name](numbers["slopes"][name]),
        )
        for name in CHOICES
    ]
    for way in PUSHES:
        for name in CHOICES:
            change = numbers["changes"][way][name]
            right = (asked if way == "forward" else {"length": below, "duration": above})[name]
            message = f"{told(change, DIGITS[name])} {UNITS[name]}"
            words = f"{name}, first step after a push {way}: changed by {message}"
            out.append(Check(words, right(change)))
    return tuple(out)


def table(numbers: Numbers) -> list[dict[str, object]]:
    return list(numbers["points"])


def draw(numbers: Mapping[BodyModel, Numbers]) -> Figure:
    figure, axes = pictures.panels(2, len(numbers), sharex=True, sharey="row")
    looks = {
        "other": ("0.75", "before, and later on"),
        "forward": (pictures.BLUE, "first after 30 N s forward"),
        "backward": (pictures.ORANGE, "first after 40 N s backward"),
    }
    for column, one in enumerate(numbers.values()):
        for row, name in enumerate(CHOICES):
            for kind, (colour, label) in looks.items():
                here = [p for p in one["points"] if kind == (p["push"] if p["when"] == "first" else "other")]
                axes[row, column].scatter(
                    [p["speed"] for p in here],
                    [p[name] for p in here],
                    6,
                    color=colour,
                    alpha=0.6,
                    label=label,
                )
        axes[1, column].set_xlabel("torso speed at touch-down, m/s")
    axes[0, 0].set_ylabel("chosen length, m")
    axes[1, 0].set_ylabel("chosen duration, s")
    pictures.legend(figure, axes[0, 0])
    pictures.bodies(axes, numbers)
    return figure


CLAIM = Claim(
    name="steps",
    title="Steps grow longer and quicker with speed",
    says="The chosen step length rises and the duration falls with the torso's speed: pushed forward the "
    "walker takes longer, quicker steps, pushed backward shorter, slower ones.",
    where="Fig. 8",
    rule="Over all footsteps the line of length against speed rises and that of duration falls; after a "
    "push of 30 N s forward the first chosen step is longer and quicker than the same walker's before, "
    "after one of 40 N s backward shorter and slower: six signs, each with all of its 95 % interval over "
    "walkers. (Duration: of early swing.)",
    bodies=("planar", "walls"),
    quick=("planar", "walls"),
    measure=measure,
    checks=checks,
    table=table,
    draw=draw,
)
