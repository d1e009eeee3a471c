"""The step back: what a walker does that cannot pass over its stance foot any more."""

from __future__ import annotations

import numpy as np

from jaxwalk.deploy.kinematics import Posture
from jaxwalk.deploy.person import Person
from jaxwalk.deploy.rigid.phases import Phase, phase_of
from jaxwalk.deploy.sensors import Estimate, capture_point
from jaxwalk.deploy.step_clock import Clock, step_length


def needed(who: Person, gravity: np.float32, posture: Posture, clock: Clock, estimate: Estimate) -> bool:
    """Whether the walker falls backward over its stance foot; never while it still pushes off."""
    if not who.gait.back_step or phase_of(clock) == Phase.TOE_OFF:
        return False
    limit = posture.x[clock.stance] - who.gait.back_step_margin
    return bool(capture_point(who, gravity, estimate) < limit)


def touched_down(
    who: Person, gravity: np.float32, posture: Posture, clock: Clock, estimate: Estimate
) -> bool:
    """Whether the swing foot carries a walker that needs it behind."""
    return bool(
        step_length(posture, clock) < -who.gait.back_step_least
        and estimate.touch[clock.swing] > who.gait.back_step_force
        and needed(who, gravity, posture, clock, estimate)
    )


def swing(
    who: Person, gravity: np.float32, posture: Posture, clock: Clock, estimate: Estimate
) -> tuple[np.float32, np.float32]:
    """(hip rate rad/s, knee angle rad) that put the swing foot behind capture point and stance foot."""
    numbers = who.gait
    place = min(
        capture_point(who, gravity, estimate) - numbers.back_step_reach,
        posture.x[clock.stance] - numbers.back_step_least,
    )
    target = np.arcsin(min(max(place / who.leg, np.float32(-0.6)), np.float32(0.6))) + estimate.pitch
    off = target - estimate.joints[clock.swing, 0]
    limit = np.float32(numbers.swing_rate_max)
    rate = min(max(numbers.terminal_hip_gain * off, -limit), limit)
    return rate, np.float32(numbers.back_step_knee if off < -numbers.back_step_near else 0)
