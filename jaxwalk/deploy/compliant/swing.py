"""The leg in the air: toe-off, a smooth way to the landing, a knee that bends and straightens late."""

from __future__ import annotations

import dataclasses

import numpy as np

from jaxwalk.deploy.compliant import stance
from jaxwalk.deploy.kinematics import Posture
from jaxwalk.deploy.person import Person
from jaxwalk.deploy.sensors import Estimate, capture_point
from jaxwalk.deploy.step_clock import Clock, step_length

_REACH_MOST = np.float32(0.9)


def back(posture: Posture, clock: Clock) -> bool:
    """Whether the foot is sent behind where the one that stands is now; a short step is at first, too."""
    return bool(np.float32(0.5) * clock.length < posture.x[clock.stance])


def _toe_off_seconds(who: Person, posture: Posture, clock: Clock) -> np.float32:
    own = who.gait.compliant
    share = own.back_toe_off if back(posture, clock) else 1
    return np.float32(own.toe_off_seconds * share)


def toe_off(who: Person, posture: Posture, clock: Clock, estimate: Estimate) -> bool:
    """Whether the trailing leg still pushes."""
    own = who.gait.compliant
    early = clock.elapsed < _toe_off_seconds(who, posture, clock)
    strong = stance.push_off(who, estimate, clock.lag) > own.toe_off_least * own.push_off_torque
    return bool(
        early
        and strong
        and posture.thigh[clock.swing] < 0
        and estimate.joints[clock.swing, 2] > -own.push_off_ankle
    )


def goal(who: Person, posture: Posture, clock: Clock, estimate: Estimate) -> np.float32:
    """Hip angle that puts the ankle half of the step's length ahead of the hip, rad."""
    reach = np.float32(0.5) * clock.length / (who.thigh + who.shank)
    reach = min(max(reach, -_REACH_MOST), _REACH_MOST)
    own = who.gait.compliant
    gain = own.back_pitch_gain if back(posture, clock) else own.swing_pitch_gain
    return np.float32(np.arcsin(reach) + gain * estimate.pitch)


def proceed(who: Person, posture: Posture, clock: Clock, estimate: Estimate, timestep: np.float32) -> Clock:
    """The clock with the swing hip's path a tick on."""
    own, swing = who.gait.compliant, clock.swing
    if toe_off(who, posture, clock, estimate):
        angle, rate = estimate.joints[swing, 0], estimate.joint_rates[swing, 0]
        return dataclasses.replace(clock, path=angle, path_rate=rate)
    to, left = goal(who, posture, clock, estimate), max(clock.duration - clock.elapsed, own.swing_soonest)
    acceleration = 6 * (to - clock.path) / left**2 - 4 * clock.path_rate / left
    acceleration = min(max(acceleration, -own.swing_acceleration_most), own.swing_acceleration_most)
    rate = min(max(clock.path_rate + timestep * acceleration, -own.swing_rate_max), own.swing_rate_max)
    return dataclasses.replace(clock, path=clock.path + timestep * rate, path_rate=rate)


def torques(
    who: Person, posture: Posture, clock: Clock, estimate: Estimate
) -> tuple[np.float32, np.float32, np.float32]:
    """Of hip, knee and ankle of the leg in the air, N m."""
    own, swing = who.gait.compliant, clock.swing
    hip, knee, ankle = estimate.joints[swing]
    hip_rate, knee_rate, ankle_rate = estimate.joint_rates[swing]
    stop = own.knee_stop * max(-knee, np.float32(0))
    end = stance.ankle_stop(who, ankle)
    if toe_off(who, posture, clock, estimate):
        bent = own.swing_knee * own.toe_off_knee_share
        pulled = own.swing_knee_stiffness * (bent - knee) - own.swing_knee_damping * knee_rate
        return np.float32(0), pulled + stop, -stance.push_off(who, estimate, clock.lag) + end
    along = own.swing_stiffness * (clock.path - hip) + own.swing_damping * (clock.path_rate - hip_rate)
    if clock.duration - clock.elapsed < own.landing_seconds:
        knees = own.landing_knee_stiffness * (own.landing_knee - knee) - own.landing_knee_damping * knee_rate
    elif back(posture, clock):
        knees = own.back_knee_stiffness * (own.back_knee - knee) - own.back_knee_damping * knee_rate
    else:
        knees = own.swing_knee_stiffness * (own.swing_knee - knee) - own.swing_knee_damping * knee_rate
    level = min(own.swing_sole - posture.shank[swing], own.swing_ankle_most)
    held = own.swing_ankle_stiffness * (level - ankle) - own.swing_ankle_damping * ankle_rate
    return along, knees + stop, held + end


def touched_down(
    who: Person, gravity: np.float32, posture: Posture, clock: Clock, estimate: Estimate
) -> bool:
    """Whether the foot has landed where it was sent."""
    numbers, own = who.gait, who.gait.compliant
    if clock.elapsed <= _toe_off_seconds(who, posture, clock) + own.passing_seconds:
        return False
    ahead, force = step_length(posture, clock), estimate.touch[clock.swing]
    if back(posture, clock):
        return bool(ahead < -own.back_ahead and force > own.back_force)
    late = clock.elapsed > own.landing_share * clock.duration
    met = capture_point(who, gravity, estimate) > posture.x[clock.swing] - own.landing_behind
    return bool(late and met and ahead > numbers.touchdown_ahead and force > numbers.touchdown_force)
