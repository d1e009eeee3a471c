"""The step's clock: which leg stands, which phase the other is in, when a foot has landed."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from jaxwalk.config import GaitConfig
from jaxwalk.deploy.kinematics import Posture
from jaxwalk.deploy.sensors import Estimate


class Phase(IntEnum):
    """What the leg does that is not in stance."""

    TOE_OFF = 1
    EARLY_SWING = 2
    TERMINAL_SWING = 3


@dataclass(frozen=True)
class Clock:
    """Where in its step a walker is.

    Attributes:
      stance: index of the stance leg, 0 left, 1 right.
      elapsed: since the last touch-down, s.
      length, duration: of the step under way: commanded length (m), early swing (s).
      toe_off, toe_off_seconds: ankle torque (N m, plantarflexion positive) and how long it lasts (s).
    """

    stance: int
    elapsed: np.float32
    length: np.float32
    duration: np.float32
    toe_off: np.float32
    toe_off_seconds: np.float32

    @property
    def swing(self) -> int:
        """Index of the leg that is not in stance, 0 left, 1 right."""
        return 1 - self.stance

    @property
    def phase(self) -> Phase:
        """Which phase the swing leg is in, by the time since the last touch-down."""
        if self.elapsed < self.toe_off_seconds:
            return Phase.TOE_OFF
        early = self.elapsed < self.toe_off_seconds + self.duration
        return Phase.EARLY_SWING if early else Phase.TERMINAL_SWING

    @property
    def progress(self) -> np.float32:
        """Share of early swing that is over: negative in toe-off, above 1 in terminal swing."""
        return (self.elapsed - self.toe_off_seconds) / self.duration


def pressed(config: GaitConfig, clock: Clock, torque: np.float32, seconds: np.float32) -> Clock:
    """The toe-off under way, stronger and longer where ``torque`` N m and ``seconds`` ask for more."""
    if config.toe_off_latched or clock.phase != Phase.TOE_OFF:
        return clock
    return dataclasses.replace(
        clock, toe_off=max(clock.toe_off, torque), toe_off_seconds=max(clock.toe_off_seconds, seconds)
    )


def step_length(posture: Posture, clock: Clock) -> np.float32:
    """How far the swing ankle is ahead of the stance ankle, m."""
    return posture.x[clock.swing] - posture.x[clock.stance]


def touched_down(config: GaitConfig, posture: Posture, clock: Clock, estimate: Estimate) -> bool:
    """Whether the swing foot has landed ahead: late enough, far enough, with force enough."""
    return bool(
        clock.progress > config.touchdown_share
        and step_length(posture, clock) > config.touchdown_ahead
        and estimate.touch[clock.swing] > config.touchdown_force
        and (estimate.speed > 0 or not config.back_step)
    )
