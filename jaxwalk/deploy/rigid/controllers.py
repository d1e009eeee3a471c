"""The controllers under the policy: stance, swing (ahead, or `back_step`), ankle toe-off.

The equations, and why they depart from the paper's, are those of `jaxwalk.control.rigid.controllers`.
"""

from __future__ import annotations

import numpy as np

from jaxwalk.config import GaitConfig
from jaxwalk.deploy.kinematics import Posture
from jaxwalk.deploy.person import Person
from jaxwalk.deploy.rigid import back_step
from jaxwalk.deploy.rigid.phases import Phase, phase_of, progress_of
from jaxwalk.deploy.sensors import Estimate
from jaxwalk.deploy.step_clock import Clock

_ZERO = np.float32(0)


def stance_hip_rate(who: Person, angle: np.float32, estimate: Estimate) -> np.float32:
    """Commanded hip rate of the stance leg at ``angle`` rad from the vertical, rad/s (eqs 6-13)."""
    numbers = who.gait
    # The IMU sits on the torso; the hip below it is slower by the torso's turning.
    speed = max(estimate.speed - who.torso * estimate.pitch_rate, numbers.stance_speed_min)
    rate = -speed / (who.leg * np.cos(angle)) * estimate.pitch / numbers.pitch_nominal
    return _limited(rate, np.float32(numbers.stance_rate_max))


def rods_inertia(mass: np.float32, length: np.float32, apart: np.float32) -> np.float32:
    """J_leg, kg m^2, about the free end of the first of two rods that meet at ``apart`` rad (eq. 20)."""
    second = (length * np.sin(apart)) ** 2 + (length * np.cos(apart) - length / 2) ** 2
    return mass * (length**2 / 12 + second + length**2 / 3)


def toe_off_torque(
    who: Person, speed: np.float32, angle: np.float32, front: np.float32, knee: np.float32
) -> np.float32:
    """Ankle torque of toe-off, N m, plantarflexion positive, never negative.

    Args:
      speed: of the torso, m/s.
      angle, front: of the trailing and the front leg from the vertical, rad.
      knee: flexion of the trailing leg, rad.
    """
    numbers = who.gait
    lost = numbers.toe_off_speed * numbers.speed_desired - speed
    if numbers.toe_off_form == "linear":
        return max(numbers.toe_off_gain * lost, _ZERO)
    leg = who.thigh + who.shank if numbers.toe_off_form == "paper" else who.leg
    rate = lost / (np.cos(angle) * leg)
    if numbers.toe_off_form == "paper":
        legs = rods_inertia(2 * who.half_leg, leg, front - angle)
    else:
        legs = rods_inertia(who.half_leg, who.leg / 2, np.float32(np.pi) - knee)
    inertia = who.torso_inertia + legs
    return max(who.ankle_damping * rate + inertia * rate / numbers.toe_off_duration, _ZERO)


def push_off(numbers: GaitConfig, limit: np.float32, torque: np.float32) -> tuple[np.float32, np.float32]:
    """(torque N m, seconds) that the ankle can do: what ``limit`` N m cuts off becomes time."""
    weak = min(torque / numbers.toe_off_full, np.float32(1))
    seconds = numbers.toe_off_duration * weak * max(np.float32(1), torque / limit)
    seconds = min(max(seconds, numbers.toe_off_duration_min), numbers.toe_off_duration_max)
    return min(torque, limit), np.float32(seconds)


def toe_off(
    who: Person, posture: Posture, estimate: Estimate, trailing: int
) -> tuple[np.float32, np.float32]:
    """(torque N m, seconds) of a toe-off of the leg ``trailing``."""
    angle = posture.thigh[trailing]
    torque = toe_off_torque(
        who, estimate.speed, angle, posture.thigh[1 - trailing], estimate.joints[trailing, 1]
    )
    if who.gait.back_step and angle >= 0:  # after a step back, that leg would push further back
        torque = _ZERO
    return push_off(who.gait, who.ankle_limit, torque)


def swing(
    who: Person, gravity: np.float32, posture: Posture, clock: Clock, estimate: Estimate
) -> tuple[np.float32, np.float32, np.float32]:
    """(hip rate rad/s, knee angle rad, ankle torque N m) of the leg that is not in stance."""
    numbers, phase = who.gait, phase_of(clock)
    hip, _, ankle = estimate.joints[clock.swing]
    reach = min(max(np.float32(0.5) * clock.length / who.leg, np.float32(-0.95)), np.float32(0.95))
    target = np.arcsin(reach) + numbers.swing_pitch_gain * estimate.pitch
    rate, knee, ankle_target = _ZERO, _ZERO, -posture.shank[clock.swing]  # which lays the sole flat
    if back_step.needed(who, gravity, posture, clock, estimate):
        rate, knee = back_step.swing(who, gravity, posture, clock, estimate)
    elif phase == Phase.EARLY_SWING:
        left = (np.float32(1) - progress_of(clock)) * clock.duration
        rate = _limited((target - hip) / max(left, np.float32(1e-3)), np.float32(numbers.swing_rate_max))
        knee = np.float32(numbers.swing_knee) if progress_of(clock) < numbers.swing_knee_share else _ZERO
        ankle_target = numbers.swing_ankle
    elif phase == Phase.TERMINAL_SWING:
        rate = numbers.terminal_hip_gain * (target - hip)
    if phase == Phase.TOE_OFF and ankle > -numbers.toe_off_ankle:
        return rate, knee, -clock.toe_off
    servo = numbers.ankle_stiffness * (ankle_target - ankle)
    return rate, knee, servo - numbers.ankle_rate_gain * estimate.joint_rates[clock.swing, 2]


def command(
    who: Person, gravity: np.float32, posture: Posture, clock: Clock, estimate: Estimate
) -> np.ndarray:
    """[6] hip rate (rad/s), knee angle (rad), ankle torque (N m); left, right."""
    # The stance knee is straight, its ankle passive unless the walker stands.
    standing = who.gait.restart_torque if clock.elapsed > who.gait.restart_seconds else _ZERO
    legs = np.empty((2, 3), np.float32)
    legs[clock.stance] = stance_hip_rate(who, posture.thigh[clock.stance], estimate), _ZERO, standing
    legs[clock.swing] = swing(who, gravity, posture, clock, estimate)
    return legs.reshape(6)


def _limited(value: np.float32, limit: np.float32) -> np.float32:
    return min(max(value, -limit), limit)
