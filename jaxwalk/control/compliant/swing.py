"""The leg in the air: toe-off, a smooth way to the landing, a knee that bends and straightens late."""

from __future__ import annotations

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from jaxwalk.config import GaitConfig
from jaxwalk.control.compliant import stance
from jaxwalk.control.posture import Posture
from jaxwalk.control.sensors import Estimate
from jaxwalk.control.step_clock import Path, StepClock
from jaxwalk.model.kinematics import Skeleton


def back(clock: StepClock, where: Posture) -> Bool[Array, ""]:
    """Whether the foot is sent behind where the one that stands is now; a short step is at first, too."""
    return 0.5 * clock.length < where.ankle[clock.stance]


def _toe_off_seconds(config: GaitConfig, clock: StepClock, where: Posture) -> Float[Array, ""]:
    own = config.compliant
    return own.toe_off_seconds * jnp.where(back(clock, where), own.back_toe_off, 1.0)


def toe_off(config: GaitConfig, clock: StepClock, where: Posture, estimate: Estimate) -> Bool[Array, ""]:
    """Whether the trailing leg still pushes: for a while, hard, behind the vertical, to its ankle's end."""
    own, swing = config.compliant, 1 - clock.stance
    early = clock.elapsed < _toe_off_seconds(config, clock, where)
    strong = stance.push_off(config, estimate, stance.lag_of(clock)) > own.toe_off_least * own.push_off_torque
    return early & strong & (where.thigh[swing] < 0) & (estimate.joints[swing, 2] > -own.push_off_ankle)


def goal(
    config: GaitConfig, body: Skeleton, clock: StepClock, where: Posture, estimate: Estimate
) -> Float[Array, ""]:
    """Hip angle that puts the ankle of a straight leg half of the step's length ahead of the hip, rad; behind
    it, in a step back."""
    reach = jnp.clip(0.5 * clock.length / (body.thigh + body.shank), -0.9, 0.9)
    own = config.compliant
    gain = jnp.where(back(clock, where), own.back_pitch_gain, own.swing_pitch_gain)
    return jnp.arcsin(reach) + gain * estimate.pitch


def proceed(
    config: GaitConfig,
    body: Skeleton,
    clock: StepClock,
    where: Posture,
    estimate: Estimate,
    timestep: float,
) -> Path:
    """The swing hip's path a tick on: the cubic from where it is, to rest at the goal when the step's time is
    over. So length and time may be changed at any tick."""
    own, swing, path = config.compliant, 1 - clock.stance, _path(clock)
    limp = toe_off(config, clock, where, estimate)
    angle = jnp.where(limp, estimate.joints[swing, 0], path.angle)
    rate = jnp.where(limp, estimate.joint_rates[swing, 0], path.rate)
    to = goal(config, body, clock, where, estimate)
    left = jnp.maximum(clock.duration - clock.elapsed, own.swing_soonest)
    acceleration = 6 * (to - angle) / left**2 - 4 * rate / left
    acceleration = jnp.clip(acceleration, -own.swing_acceleration_most, own.swing_acceleration_most)
    moving = jnp.clip(rate + timestep * acceleration, -own.swing_rate_max, own.swing_rate_max)
    rate = jnp.where(limp, rate, moving)
    return Path(angle=jnp.where(limp, angle, angle + timestep * rate), rate=rate)


def _path(clock: StepClock) -> Path:
    assert clock.path is not None  # compliant legs have one
    return clock.path


def torques(config: GaitConfig, clock: StepClock, where: Posture, estimate: Estimate) -> Float[Array, "3"]:
    """[3] of hip, knee and ankle of the leg in the air, N m."""
    own, swing, path = config.compliant, 1 - clock.stance, _path(clock)
    hip, knee, ankle = estimate.joints[swing]
    hip_rate, knee_rate, ankle_rate = estimate.joint_rates[swing]
    limp = toe_off(config, clock, where, estimate)
    along = own.swing_stiffness * (path.angle - hip) + own.swing_damping * (path.rate - hip_rate)
    landing = clock.duration - clock.elapsed < own.landing_seconds
    bent = own.swing_knee * jnp.where(limp, own.toe_off_knee_share, 1.0)
    passing = own.swing_knee_stiffness * (bent - knee) - own.swing_knee_damping * knee_rate
    # The thigh that is pulled back would throw the shank forward, onto the floor.
    lifted = own.back_knee_stiffness * (own.back_knee - knee) - own.back_knee_damping * knee_rate
    passing = jnp.where(back(clock, where) & ~limp, lifted, passing)
    straight = own.landing_knee_stiffness * (own.landing_knee - knee) - own.landing_knee_damping * knee_rate
    stop = own.knee_stop * jnp.maximum(-knee, 0.0)
    level = jnp.minimum(own.swing_sole - where.shank[swing], own.swing_ankle_most)
    held = own.swing_ankle_stiffness * (level - ankle) - own.swing_ankle_damping * ankle_rate
    return jnp.stack(
        [
            jnp.where(limp, 0.0, along),
            jnp.where(landing & ~limp, straight, passing) + stop,
            jnp.where(limp, -stance.push_off(config, estimate, stance.lag_of(clock)), held)
            + stance.ankle_stop(config, ankle),
        ]
    )


def touched_down(config: GaitConfig, clock: StepClock, where: Posture, estimate: Estimate) -> Bool[Array, ""]:
    """Whether the foot has landed where it was sent: ahead, late enough, or behind, with force enough."""
    own, swing = config.compliant, 1 - clock.stance
    ahead = where.ankle[swing] - where.ankle[clock.stance]
    force = estimate.touch[swing]
    late = clock.elapsed > own.landing_share * clock.duration
    met = where.capture > where.ankle[swing] - own.landing_behind
    loaded = (ahead > config.touchdown_ahead) & (force > config.touchdown_force)
    forward = ~back(clock, where) & late & loaded & met
    behind = back(clock, where) & (ahead < -own.back_ahead) & (force > own.back_force)
    return (forward | behind) & (clock.elapsed > _toe_off_seconds(config, clock, where) + own.passing_seconds)
