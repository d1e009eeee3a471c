"""The phases of a rigid walker's step, by the time since touch-down, and when its swing foot has landed."""

from __future__ import annotations

import dataclasses
from enum import IntEnum

import numpy as np

from jaxwalk.config import GaitConfig
from jaxwalk.deploy.kinematics import Posture
from jaxwalk.deploy.sensors import Estimate
from jaxwalk.deploy.step_clock import Clock, step_length


class Phase(IntEnum):
    """What the leg does that is not in stance."""

    TOE_OFF = 1
    EARLY_SWING = 2
    TERMINAL_SWING = 3


def phase_of(clock: Clock) -> Phase:
    """Which phase the swing leg is in, by the time since the last touch-down."""
    if clock.elapsed < clock.toe_off_seconds:
        return Phase.TOE_OFF
    early = clock.elapsed < clock.toe_off_seconds + clock.duration
    return Phase.EARLY_SWING if early else Phase.TERMINAL_SWING


def progress_of(clock: Clock) -> np.float32:
    """Share of early swing that is over: negative in toe-off, above 1 in terminal swing."""
    return (clock.elapsed - clock.toe_off_seconds) / clock.duration


def pressed(config: GaitConfig, clock: Clock, torque: np.float32, seconds: np.float32) -> Clock:
    """The toe-off under way, stronger and longer where ``torque`` N m and ``seconds`` ask for more."""
    if config.toe_off_latched or phase_of(clock) != Phase.TOE_OFF:
        return clock
    return dataclasses.replace(
        clock, toe_off=max(clock.toe_off, torque), toe_off_seconds=max(clock.toe_off_seconds, seconds)
    )


def touched_down(config: GaitConfig, posture: Posture, clock: Clock, estimate: Estimate) -> bool:
    """Whether the swing foot has landed ahead: late enough, far enough, with force enough."""
    return bool(
        progress_of(clock) > config.touchdown_share
        and step_length(posture, clock) > config.touchdown_ahead
        and estimate.touch[clock.swing] > config.touchdown_force
        and (estimate.speed > 0 or not config.back_step)
    )
