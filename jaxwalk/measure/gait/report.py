"""What a recording says: curves over the cycle, figures, and where the energy goes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from operator import itemgetter
from typing import Any

import jax
import numpy as np
from jaxtyping import Float

from jaxwalk.common.errors import UserError
from jaxwalk.config import REFERENCE_MASS
from jaxwalk.learn.policies.named import Subject
from jaxwalk.measure.gait import energy, human, measures, record, signals, strides
from jaxwalk.measure.gait.human import Human
from jaxwalk.measure.gait.record import Ticks
from jaxwalk.task import scenarios

AT_SPEEDS = (
    "speed",
    "step_length",
    "cadence",
    "double_support_share",
    "cost_of_transport_by_leg",
    "cost_of_transport",
)
"""Of `measures.UNITS`, what is told of further speeds."""
SIDES = ("left", "right")


@dataclass(frozen=True)
class Curve:
    """One quantity of one side over the cycle.

    Attributes:
      mean, sd: [POINTS] over all strides of all walkers.
    """

    mean: Float[np.ndarray, "P"]
    sd: Float[np.ndarray, "P"]


@dataclass(frozen=True)
class Report:
    """A gait.

    Attributes:
      curves: (name of `signals.UNITS`, side) -> curve.
      people: name of `measures.UNITS` -> what people of the walkers' stature do, at their speed where known.
      result: all scalars, as JSON values.
    """

    curves: dict[tuple[str, str], Curve]
    people: dict[str, Human]
    result: dict[str, Any]


class NoStride(UserError):
    """Nobody made a whole stride with each leg."""


def make(
    subject: Subject,
    walkers: int,
    seconds: float,
    seed: int,
    tell: Callable[[float], None] = lambda share: None,
) -> Report:
    """Walk, unpushed, and measure every whole stride of those who stay up.

    Raises:
      NoStride: nobody stays up, or makes a whole stride.
    """
    config, none = subject.config, np.zeros(walkers, np.float32)
    started = scenarios.batch(config, none, none, scenarios.keys(seed, scenarios.CALM, walkers))
    dt, mass = config.physics.timestep, config.body.mass
    threshold = config.gait.touchdown_force * mass / REFERENCE_MASS
    rows, shapes, odd, fell, walker = [], [], 0, 0, 0
    for batch in record.record(subject, started, seconds, tell):
        for i in range(batch.fell.shape[0]):
            one: Ticks = jax.tree.map(itemgetter(i), batch)
            walker += 1
            if one.fell.any():
                fell += 1
                continue
            measured, curves, left_out = _strides(one, dt, mass, threshold)
            rows += [(walker, side, values) for side, values in measured]
            shapes += curves
            odd += left_out
    if {row[1] for row in rows} != {0, 1}:
        raise NoStride(
            f"policy {subject.name} makes no whole stride with each leg in {seconds:g} s, {fell} of "
            f"{walkers} walkers fell: give --seconds more, or a policy that walks"
        )
    found = measures.Measured.of(rows)
    people = human.people(config.body.height, float(found.values["speed"].mean()))
    return Report(_curves(found, np.stack(shapes)), people, _result(found, people, walkers, fell, odd))


def _strides(
    ticks: Ticks, timestep: float, mass: float, threshold: float
) -> tuple[list[tuple[int, dict[str, float]]], list[np.ndarray], int]:
    """(side, figures) and [POINTS, Q] curves of each cycle, and how many odd ones were left out."""
    contact = np.asarray(ticks.forces.ground)[..., 1] > threshold
    shortest = round(strides.BOUNCE_SECONDS / timestep)
    contact = np.stack([strides.settled(contact[:, side], shortest) for side in (0, 1)], axis=1)
    cycles, odd = strides.cycles(contact)
    told = signals.of_walker(ticks, timestep, mass)
    stacked = np.stack([told[name] for name in signals.UNITS], axis=-1)
    figures = [(c.side, measures.of_cycle(ticks, told, c, timestep, mass)) for c in cycles]
    return figures, [strides.normalised(stacked[:, c.side], c) for c in cycles], odd


def _curves(measured: measures.Measured, shapes: Float[np.ndarray, "C P Q"]) -> dict[tuple[str, str], Curve]:
    found = {}
    for i, side in enumerate(SIDES):
        own = shapes[measured.side == i]
        for q, name in enumerate(signals.UNITS):
            found[name, side] = Curve(own[..., q].mean(0), own[..., q].std(0))
    return found


def _result(
    measured: measures.Measured, people: dict[str, Human], walkers: int, fell: int, odd: int
) -> dict[str, Any]:
    summary = measures.summary(measured)
    for name, one in people.items():
        summary[name]["human"] = {
            "mean": one.mean, "low": one.low, "high": one.high, "source": one.source,
        }  # fmt: skip
    return {
        "walkers": walkers,
        "fell": fell,
        "strides": {side: int(np.sum(measured.side == i)) for i, side in enumerate(SIDES)},
        "strides_left_out": odd,
        "measures": summary,
        "symmetry": measures.symmetry(measured),
        "definitions": {
            "conventions": signals.CONVENTIONS,
            "impact": measures.IMPACT,
            "work": energy.DEFINITION,
            "symmetry": measures.SYMMETRY,
            "strides_left_out": "the other leg did not touch down just once within them; walkers that fell "
            "are left out whole",
        },
        "sources": human.SOURCES,
    }
