"""The leg that stands: it holds the torso, yields under the load, and pushes off before the other lands."""

from __future__ import annotations

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.config import GaitConfig
from jaxwalk.control import posture
from jaxwalk.control.posture import Posture
from jaxwalk.control.sensors import Estimate
from jaxwalk.control.step_clock import StepClock
from jaxwalk.model.kinematics import Skeleton

_BALANCE_RAMP = 0.1  # rad over which balancing by the ankle ends
_ERROR_MOST = 2.0  # legs off the usual landing: what is further off is not told apart


def faster(config: GaitConfig) -> Float[Array, ""]:
    """How much faster is asked for than the numbers are of, m/s."""
    return jnp.asarray(config.speed_desired - config.compliant.speed_usual)


def lag_of(clock: StepClock) -> Float[Array, ""]:
    """`StepClock.lag`, m."""
    assert clock.lag is not None  # compliant legs have one
    return clock.lag


def lagging(config: GaitConfig, clock: StepClock, estimate: Estimate, timestep: float) -> Float[Array, ""]:
    """`StepClock.lag` a tick on: the error of the speed, integrated with a leak. What pulls or pushes
    steadily (a pack, a slope) is answered by it; a push is too short to count for much."""
    own = config.compliant
    off = jnp.clip(config.speed_desired - estimate.speed, -own.lag_speed, own.lag_speed)
    lag = lag_of(clock)
    lag = lag + timestep * (off - lag / own.lag_seconds)
    return jnp.clip(lag, -own.lag_most, own.lag_most)


def capture_error(config: GaitConfig, body: Skeleton, clock: StepClock, where: Posture) -> Float[Array, ""]:
    """How much further ahead of the stance ankle the capture point will be at the landing than it is in
    steady walking, m: it runs away from the foot as exp(w0 t) (Englsberger et al. 2015)."""
    own = config.compliant
    more = faster(config)
    left = jnp.maximum(own.landing_time + own.duration_speed * more - clock.elapsed, 0.0)
    ahead = where.capture - where.ankle[clock.stance]
    usual = own.landing_capture + own.capture_speed * more + own.lag_capture * lag_of(clock)
    error = ahead * jnp.exp(posture.falling_rate(body) * left) - usual
    most = _ERROR_MOST * body.leg
    return jnp.clip(error, -most, most)


def hip(
    config: GaitConfig,
    body: Skeleton,
    clock: StepClock,
    where: Posture,
    estimate: Estimate,
    error: Float[Array, ""],
) -> Float[Array, ""]:
    """Torque of the stance hip, N m: a servo of the rate w = -a' phi / phi0 that keeps the torso upright
    (eqs 6-13), phi from where it shall lean."""
    own, stance = config.compliant, clock.stance
    # The IMU sits on the torso; the hip below it is slower by the torso's turning.
    speed = jnp.maximum(estimate.speed - body.torso * estimate.pitch_rate, own.hip_speed_min)
    ankle_rate = speed / where.drop[stance]
    off = estimate.pitch - own.lag_pitch * lag_of(clock) - own.pitch_offset - own.pitch_capture_gain * error
    rate = jnp.clip(-ankle_rate * off / own.pitch_nominal, -own.hip_rate_max, own.hip_rate_max)
    return own.hip_damping * (rate - estimate.joint_rates[stance, 0])


def knee(config: GaitConfig, clock: StepClock, estimate: Estimate) -> Float[Array, ""]:
    """Torque of the stance knee, N m: a damped spring about a flexion."""
    own = config.compliant
    share = jnp.clip(clock.elapsed / own.knee_seconds, 0.0, 1.0)
    rest = own.knee_loading + (own.knee_standing - own.knee_loading) * share
    _, angle, _ = estimate.joints[clock.stance]
    _, rate, _ = estimate.joint_rates[clock.stance]
    return own.knee_stiffness * (rest - angle) - own.knee_damping * rate


def push_off(config: GaitConfig, estimate: Estimate, lag: Float[Array, ""]) -> Float[Array, ""]:
    """Plantarflexion torque of a whole push-off, N m, never negative: the more, the slower the walker.

    A push before the other foot lands costs a quarter of what the hip would need after it (Kuo 2002).
    """
    own = config.compliant
    lost = own.push_off_share * config.speed_desired - estimate.speed
    usual = own.push_off_torque + own.push_off_speed * faster(config)
    return jnp.maximum(usual + own.push_off_gain * lost + own.lag_push_off * lag, 0.0)


def ankle(
    config: GaitConfig,
    clock: StepClock,
    where: Posture,
    estimate: Estimate,
    error: Float[Array, ""],
) -> Float[Array, ""]:
    """Torque of the stance ankle, N m: a damped spring beyond a slack, then push-off, once the leg is behind
    the vertical and the body falls forward over it.

    Balancing by the toes ends as the heel rises: beyond that the leg would vault the body into the air. That
    by the heel ends as the toes rise: the foot would turn up, and the body stand on its edge.
    """
    own, stance = config.compliant, clock.stance
    _, _, angle = estimate.joints[stance]
    _, _, rate = estimate.joint_rates[stance]
    behind = jnp.arctan2(-where.ankle[stance], where.drop[stance]) - own.push_off_angle
    forward = (where.capture > where.ankle[stance]) & (angle > -own.push_off_ankle)
    share = jnp.where(forward, jnp.clip(behind / own.push_off_ramp, 0.0, 1.0), 0.0)
    spring = own.ankle_stiffness * jnp.minimum(own.ankle_slack - angle, 0.0)
    toes = (angle + own.balance_ankle) / _BALANCE_RAMP
    heel = (own.balance_sole - where.shank[stance] - angle) / _BALANCE_RAMP
    balance = -own.ankle_capture_gain * error * jnp.clip(jnp.where(error > 0, toes, heel), 0.0, 1.0)
    resting = spring + balance
    pushed = resting + share * (-push_off(config, estimate, lag_of(clock)) - resting)
    return pushed - own.ankle_damping * rate + ankle_stop(config, angle)


def ankle_stop(config: GaitConfig, angle: Float[Array, ""]) -> Float[Array, ""]:
    """What keeps an ankle from plantarflexing further than people's do, N m."""
    own = config.compliant
    return own.ankle_stop * jnp.maximum(-own.ankle_end - angle, 0.0)
