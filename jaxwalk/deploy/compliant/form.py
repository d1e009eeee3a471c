"""Compliant legs through a step: see `jaxwalk.deploy.forms`."""

from __future__ import annotations

import dataclasses

import numpy as np

from jaxwalk.deploy.compliant import stance as standing
from jaxwalk.deploy.compliant import step_plan, swing
from jaxwalk.deploy.kinematics import Posture
from jaxwalk.deploy.person import Person
from jaxwalk.deploy.sensors import Estimate, Sensors
from jaxwalk.deploy.step_clock import Clock


def let_go(said: Sensors) -> np.ndarray:
    """[6] no torque."""
    return np.zeros(6, np.float32)


def start(who: Person, gravity: np.float32, posture: Posture, estimate: Estimate, stance: int) -> Clock:
    """The clock at the touch-down of ``stance``, its step the nominal one."""
    length, duration = np.float32(who.gait.length_nominal), np.float32(who.gait.duration_nominal)
    zero = np.float32(0)
    push, seconds = standing.push_off(who, estimate, zero), np.float32(who.gait.compliant.toe_off_seconds)
    fresh = Clock(stance, zero, length, duration, push, seconds, zero, zero, zero)
    return _begun(fresh, estimate, 1 - stance)


def command(
    who: Person, gravity: np.float32, posture: Posture, clock: Clock, estimate: Estimate
) -> np.ndarray:
    """[6] torques of hip, knee and ankle, N m, that the joints can give; left, right."""
    error = standing.capture_error(who, gravity, posture, clock, estimate)
    legs = np.empty((2, 3), np.float32)
    legs[clock.stance] = (
        standing.hip(who, posture, clock, estimate, error),
        standing.knee(who, clock, estimate),
        standing.ankle(who, gravity, posture, clock, estimate, error),
    )
    legs[clock.swing] = swing.torques(who, posture, clock, estimate)
    if who.strength is None:
        return legs.reshape(6)
    turning = estimate.joint_rates / who.rate
    forth, back = (_left(who.strength[way], sign * turning) for way, sign in ((0, 1), (1, -1)))
    return np.clip(legs, -who.torque * back, who.torque * forth).reshape(6)


def proceed(
    who: Person,
    gravity: np.float32,
    posture: Posture,
    clock: Clock,
    estimate: Estimate,
    timestep: np.float32,
) -> tuple[Clock, bool]:
    """The clock after a tick, and whether a foot landed in it."""
    landed = swing.touched_down(who, gravity, posture, clock, estimate)
    if landed:
        trailing = clock.stance
        clock = dataclasses.replace(clock, stance=clock.swing, elapsed=np.float32(0))
        clock = _begun(clock, estimate, trailing)
    if who.gait.steps == "planned":
        error = standing.capture_error(who, gravity, posture, clock, estimate)
        length, duration = step_plan.planned(who, gravity, posture, clock, estimate, error)
        clock = dataclasses.replace(clock, length=length, duration=duration)
    clock = swing.proceed(who, posture, clock, estimate, timestep)
    lag = standing.lagging(who, clock, estimate, timestep)
    return dataclasses.replace(clock, lag=lag, toe_off=standing.push_off(who, estimate, lag)), landed


def _begun(clock: Clock, estimate: Estimate, leg: int) -> Clock:
    """``clock`` with the path of a ``leg`` that begins to swing: from where it is."""
    return dataclasses.replace(clock, path=estimate.joints[leg, 0], path_rate=estimate.joint_rates[leg, 0])


def _left(strength: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """[2, 3] what is left of the largest torques at ``rate`` rad/s that way, N m.

    Args:
      strength: [3, 3] largest torque, N m; rates at which three quarters and half of it are left, rad/s.
    """
    most, c, d = strength
    w = np.maximum(rate, np.float32(0))
    share = (2 * c * d + w * (d - 3 * c)) / (2 * c * d + w * (2 * d - 4 * c))
    return most * np.maximum(share, np.float32(0))
