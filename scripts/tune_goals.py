"""What a search for a walk asks of it: measures of unpushed walking, pushes, and circumstances."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from jaxwalk.config import Config
from jaxwalk.model.burdens import BACKPACK, FRONT_PACK, Burden


@dataclass(frozen=True)
class Goal:
    """What is asked of a measure: nothing more at ``aim``, cost 1 at ``must``, four times as steep beyond."""

    aim: float
    must: float

    def cost(self, value: np.ndarray) -> np.ndarray:
        """Of each value; one that is not finite is as bad as can be."""
        off = (value - self.aim) / (self.must - self.aim)
        worse = np.maximum(off, 0.0) + 3.0 * np.maximum(off - 1.0, 0.0)
        return np.where(np.isfinite(worse), np.minimum(worse, 20.0), 20.0)


GOALS = {
    "speed_off": Goal(0.01, 0.04),
    "joint_work": Goal(0.11, 0.16),
    "leg_work": Goal(0.09, 0.13),
    "force": Goal(1.4, 2.1),
    "knee_too_straight": Goal(-12.0, -8.0),
    "knee_too_bent": Goal(20.0, 22.0),
    "double_too_short": Goal(-0.17, -0.135),
    "step_too_short": Goal(-0.58, -0.53),
    "step_too_long": Goal(0.68, 0.74),
    "hip_moment": Goal(1.0, 1.5),
    "hip_power": Goal(1.5, 2.7),
    "pitch_range": Goal(0.05, 0.075),
    "pitch_mean": Goal(0.06, 0.1),
    "passing_too_straight": Goal(-55.0, -40.0),
    "standing": Goal(6.0, 18.0),
    "dorsiflexion": Goal(12.0, 25.0),
}
"""Measures of unpushed walking, in the units of `measures`."""
PUSHES = {
    45.0: 4.0, 75.0: 10.0, 95.0: 16.0, 112.0: 16.0, 128.0: 8.0, 145.0: 3.0,
    -25.0: 4.0, -45.0: 10.0, -62.0: 16.0, -78.0: 18.0, -93.0: 14.0, -108.0: 8.0, -122.0: 3.0,
}  # fmt: skip
"""Impulses, N s, and what it costs that nobody survives one. From turn to turn they are smaller by up to
`WEAKER`, or the search would learn these very ones."""
WEAKER = 0.14
FALL = 30.0
"""What it costs that nobody walks on unpushed."""
USUAL = Burden(0.0, 0.0, 0.0, 0.0, Config().physics.friction)


@dataclass(frozen=True)
class Circumstance:
    """Walkers that bear something, are asked for another speed, see less, or are pushed ``again`` after so
    many seconds; what it costs that nobody survives each impulse there, 0 being none; what their speed should
    be off by."""

    prices: tuple[tuple[float, float], ...] = ((0.0, 6.0), (45.0, 3.0), (-45.0, 3.0))
    burden: Burden = USUAL
    speed: float = 1.0
    again: float = 0.0
    noise: float = 1.0
    off: Goal = Goal(0.15, 0.4)


HARD = {
    "late": Circumstance(
        ((0.0, 10.0), (62.0, 7.0), (84.0, 7.0), (102.0, 5.0), (-50.0, 7.0), (-68.0, 7.0)),
        dataclasses.replace(USUAL, delay=0.02, strength=0.8),
    ),
    "twice": Circumstance(
        ((0.0, 1.0), (55.0, 5.0), (85.0, 4.0), (-40.0, 5.0), (-56.0, 8.0), (-75.0, 6.0)), again=1.0
    ),
    "uphill": Circumstance(burden=dataclasses.replace(USUAL, slope=math.radians(3))),
    "downhill": Circumstance(burden=dataclasses.replace(USUAL, slope=math.radians(-3))),
    "backpack": Circumstance(
        ((0.0, 4.0), (45.0, 1.0), (-45.0, 1.0)),
        dataclasses.replace(USUAL, mass=20.0, ahead=BACKPACK[0], up=BACKPACK[1]),
        off=Goal(0.3, 0.8),
    ),
    "front pack": Circumstance(burden=dataclasses.replace(USUAL, mass=25.0, ahead=FRONT_PACK[0])),
    "slippery": Circumstance(burden=dataclasses.replace(USUAL, friction=0.4)),
    "noisy": Circumstance(noise=4.0),
    "slow": Circumstance(speed=0.65, off=Goal(0.03, 0.1)),
    "fast": Circumstance(speed=1.35, off=Goal(0.03, 0.1)),
}
"""What a walk meets besides."""
