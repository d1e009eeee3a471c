"""The controllers under the policy: stance, swing (ahead, or `back_step`), ankle toe-off.

Equation numbers are those of Liu et al., "Implementation of DDPG for Controlling
Dynamic Bipedal Walking". Every function is pure and sees one walker; ``config`` holds
that walker's own (scaled) numbers.
"""

from __future__ import annotations

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.config import GaitConfig
from jaxwalk.control.person import Inertias
from jaxwalk.control.rigid import back_step
from jaxwalk.control.rigid.phases import Phase, swing_phase, swing_progress
from jaxwalk.control.sensors import Estimate
from jaxwalk.control.step_clock import StepClock
from jaxwalk.model.kinematics import Skeleton, shank_angles, thigh_angles


def stance_hip_rate(
    config: GaitConfig,
    leg: Float[Array, ""],
    hip_speed: Float[Array, ""],
    angle: Float[Array, ""],
    pitch: Float[Array, ""],
) -> Float[Array, ""]:
    """Commanded hip rate of the stance leg, rad/s (eqs 6-13).

    The stance leg turns about the ankle at a' = v / (L cos a); the hip is turned at
    w = K phi, K = -a' / phi0, so that the pitch settles at phi0. Departs from eq. 9 in
    two guards: v is at least ``stance_speed_min``, since K would vanish with it and
    leave the torso alone when the walker is slowest, and |w| is limited.

    Args:
      leg: L, m.
      hip_speed: forward speed of the hip, v_p, m/s.
      angle: of the leg from the vertical, a, rad.
      pitch: phi, rad.
    """
    ankle_rate = jnp.maximum(hip_speed, config.stance_speed_min) / (leg * jnp.cos(angle))
    rate = -ankle_rate * pitch / config.pitch_nominal
    return jnp.clip(rate, -config.stance_rate_max, config.stance_rate_max)


def early_swing_hip_rate(
    config: GaitConfig, target: Float[Array, ""], angle: Float[Array, ""], time_left: Float[Array, ""]
) -> Float[Array, ""]:
    """Hip rate that reaches ``target`` rad when the early swing ends, rad/s; limited."""
    rate = (target - angle) / jnp.maximum(time_left, 1e-3)
    return jnp.clip(rate, -config.swing_rate_max, config.swing_rate_max)


def terminal_swing_hip_rate(
    config: GaitConfig, target: Float[Array, ""], angle: Float[Array, ""]
) -> Float[Array, ""]:
    """Hip rate that holds ``target`` while the knee straightens, rad/s."""
    return config.terminal_hip_gain * (target - angle)


def swing_target(
    config: GaitConfig, leg: Float[Array, ""], length: Float[Array, ""], pitch: Float[Array, ""]
) -> Float[Array, ""]:
    """Hip angle whose straight leg would land half of ``length`` ahead of the hip, rad.

    Relative to the torso, plus a share of its pitch.
    """
    return jnp.arcsin(jnp.clip(0.5 * length / leg, -0.95, 0.95)) + config.swing_pitch_gain * pitch


def rods_inertia(
    mass: Float[Array, ""], length: Float[Array, ""], apart: Float[Array, ""]
) -> Float[Array, ""]:
    """J_leg, kg m^2, about the free end of the first of two rods that meet at b = ``apart`` rad (eq. 20).

    Args:
      mass: of each, kg. length: of each, m.
    """
    second = (length * jnp.sin(apart)) ** 2 + (length * jnp.cos(apart) - length / 2) ** 2
    return mass * (length**2 / 12 + second + length**2 / 3)


def toe_off_torque(
    config: GaitConfig,
    inertias: Inertias,
    leg: Float[Array, ""],
    speed: Float[Array, ""],
    angle: Float[Array, ""],
    front: Float[Array, ""],
    knee: Float[Array, ""],
) -> Float[Array, ""]:
    """Ankle torque of toe-off, N m, plantarflexion positive, never negative.

    Both restore dv = v_ref - v, v_ref being ``toe_off_speed`` for each m/s of v_desire: v is that of the
    touch-down, when the torso is faster than on the mean of a step.
    ``paper``: eqs 14-22. For the trailing leg dv is an angular speed of da' = dv / (l cos a); giving it
    to both legs about the front ankle within ``toe_off_duration`` while the torso stays upright takes
    tau = tau_c + (J_torso + J_leg) da' / dt.
    ``one-leg``: the same with the J_leg of the trailing leg alone, thigh and shank, about the hip; for
    policies of before.
    ``linear``: gain dv: the same line with tuned constants, since the rigid
    legs of the paper's model leave out what the landing itself absorbs.

    Args:
      leg: that turns, from the hip to its ankle (``paper``) or its sole (the others), m.
      speed: of the torso, m/s.
      angle, front: of the trailing and the front leg from the vertical, rad.
      knee: flexion of the trailing leg, rad.
    """
    lost = config.toe_off_speed * config.speed_desired - speed
    if config.toe_off_form == "linear":
        return jnp.maximum(config.toe_off_gain * lost, 0.0)
    rate = lost / (jnp.cos(angle) * leg)
    if config.toe_off_form == "paper":
        legs = rods_inertia(2 * inertias.leg_mass, leg, front - angle)
    else:
        legs = rods_inertia(inertias.leg_mass, leg / 2, jnp.pi - knee)
    inertia = inertias.torso + legs
    return jnp.maximum(inertias.damping * rate + inertia * rate / config.toe_off_duration, 0.0)


def push_off(
    config: GaitConfig, limit: Float[Array, ""], torque: Float[Array, ""]
) -> tuple[Float[Array, ""], Float[Array, ""]]:
    """(torque N m, seconds) that the ankle can do: what ``limit`` N m cuts off becomes time.

    By eq. 21 it is the angular impulse tau dt that restores the speed. A torque below
    ``toe_off_full`` takes less time, which the swing of a fast walker needs. In the paper the
    time is constant: its shortest and longest are ``toe_off_duration``.
    """
    weak = jnp.minimum(torque / config.toe_off_full, 1.0)
    seconds = config.toe_off_duration * weak * jnp.maximum(1.0, torque / limit)
    seconds = jnp.clip(seconds, config.toe_off_duration_min, config.toe_off_duration_max)
    return jnp.minimum(torque, limit), seconds


def ankle_servo(
    config: GaitConfig, target: Float[Array, ""], angle: Float[Array, ""], rate: Float[Array, ""]
) -> Float[Array, ""]:
    """Torque that holds a foot in the air, N m, dorsiflexion positive."""
    return config.ankle_stiffness * (target - angle) - config.ankle_rate_gain * rate


def standing_ankle_torque(config: GaitConfig, gait: StepClock) -> Float[Array, ""]:
    """Torque of the stance ankle, N m, dorsiflexion positive: none, but for a walker that stands.

    One that a push has stopped just above its stance foot may balance there for seconds, an inverted
    pendulum that nothing disturbs. Dorsiflexion moves its centre of pressure behind it.
    """
    return jnp.where(gait.elapsed > config.restart_seconds, config.restart_torque, 0.0)


def command(config: GaitConfig, body: Skeleton, gait: StepClock, estimate: Estimate) -> Float[Array, "6"]:
    """All six actuators: hip rate (rad/s), knee angle (rad), ankle torque (N m); left, right."""
    stance, swing = gait.stance, 1 - gait.stance
    thigh, shank = (
        thigh_angles(estimate.joints, estimate.pitch),
        shank_angles(estimate.joints, estimate.pitch),
    )
    leg = body.leg
    phase = swing_phase(gait)
    progress = swing_progress(gait)

    # The IMU sits on the torso; the hip below it is slower by the torso's turning.
    hip_speed = estimate.speed - body.torso * estimate.pitch_rate
    stance_hip = stance_hip_rate(config, leg, hip_speed, thigh[stance], estimate.pitch)

    hip, _, ankle = estimate.joints[swing]
    target = swing_target(config, leg, gait.length, estimate.pitch)
    early_hip = early_swing_hip_rate(config, target, hip, (1.0 - progress) * gait.duration)
    swing_hip = jnp.where(
        phase == Phase.EARLY_SWING,
        early_hip,
        jnp.where(phase == Phase.TERMINAL_SWING, terminal_swing_hip_rate(config, target, hip), 0.0),
    )
    bent = (phase == Phase.EARLY_SWING) & (progress < config.swing_knee_share)
    swing_knee = jnp.where(bent, config.swing_knee, 0.0)
    back = back_step.needed(config, body, gait, estimate)
    back_hip, back_knee = back_step.swing(config, body, gait, estimate)
    swing_hip, swing_knee = jnp.where(back, back_hip, swing_hip), jnp.where(back, back_knee, swing_knee)
    level = -shank[swing]  # the ankle angle that lays the sole flat
    ankle_target = jnp.where((phase == Phase.EARLY_SWING) & ~back, config.swing_ankle, level)
    swing_ankle = jnp.where(
        (phase == Phase.TOE_OFF) & (ankle > -config.toe_off_ankle),
        -gait.toe_off,
        ankle_servo(config, ankle_target, ankle, estimate.joint_rates[swing, 2]),
    )
    zero = jnp.zeros_like(stance_hip)
    # Knee straight, ankle passive while it walks.
    standing = jnp.stack([stance_hip, zero, standing_ankle_torque(config, gait)])
    swinging = jnp.stack([swing_hip, swing_knee, swing_ankle])
    return jnp.where(gait.is_stance[:, None], standing, swinging).reshape(6)
