"""From the plant's readings to what a controller may know.

IMU at the torso's centre, encoders and soles, each with white noise and a bias that is
constant for a walker; forward velocity and acceleration then pass a moving mean and a
Kalman filter (the paper's fig. 3).
"""

from __future__ import annotations

from functools import lru_cache

import jax
import jax.numpy as jnp
import numpy as np
from flax import struct
from jaxtyping import Array, Bool, Float, PRNGKeyArray

from jaxwalk.config import GRAVITY, SensorConfig
from jaxwalk.model.kinematics import Skeleton, ankles
from jaxwalk.model.physics import Readings


class Estimate(struct.PyTreeNode):
    """What the controllers and the policy are told.

    Attributes:
      speed, acceleration: filtered forward speed and acceleration of the torso's centre, m/s, m/s^2.
      pitch, pitch_rate: of the torso, forward positive, rad, rad/s.
      joints, joint_rates: [2, 3] hip, knee, ankle of each leg, rad, rad/s.
      touch: [2] force under each sole, N.
    """

    speed: Float[Array, ""]
    acceleration: Float[Array, ""]
    pitch: Float[Array, ""]
    pitch_rate: Float[Array, ""]
    joints: Float[Array, "2 3"]
    joint_rates: Float[Array, "2 3"]
    touch: Float[Array, "2"]


class SensorState(struct.PyTreeNode):
    """Memory of the instruments.

    Attributes:
      noise: scale of this walker's noise and bias, 1 realistic.
      bias: [3] constant error of velocity (m/s), acceleration (m/s^2), pitch (rad).
      last_velocity: forward velocity one tick ago, noise-free, m/s (the accelerometer's mean over a tick).
      history: [N, 2] the last N (velocity, acceleration) for the moving mean.
      filtered: [2] the Kalman filter's velocity and acceleration.
    """

    noise: Float[Array, ""]
    bias: Float[Array, "3"]
    last_velocity: Float[Array, ""]
    history: Float[Array, "N 2"]
    filtered: Float[Array, "2"]


@lru_cache(maxsize=16)
def kalman_gain(config: SensorConfig, timestep: float) -> np.ndarray:
    """[2, 2] steady-state gain for the state (velocity, acceleration), both measured.

    The acceleration is a random walk, the velocity its integral; the gain solves the
    discrete Riccati equation by iterating it until it stands.
    """
    advance = np.array([[1.0, timestep], [0.0, 1.0]])
    drift = np.array([timestep / 2, 1.0])
    process = np.outer(drift, drift) * config.kalman_process**2
    error = np.diag([config.kalman_velocity**2, config.kalman_acceleration**2])
    covariance = np.eye(2)
    for _ in range(10_000):
        prior = advance @ covariance @ advance.T + process
        gain = prior @ np.linalg.inv(prior + error)
        posterior = (np.eye(2) - gain) @ prior
        if np.allclose(posterior, covariance, rtol=1e-10, atol=0):
            break
        covariance = posterior
    return gain.astype(np.float32)


def filter_step(
    config: SensorConfig, timestep: float, state: SensorState, measured: Float[Array, "2"]
) -> tuple[Float[Array, "N 2"], Float[Array, "2"]]:
    """Moving mean, then Kalman filter, of one (velocity, acceleration); the new history and state."""
    history = jnp.concatenate([state.history[1:], measured[None]])
    mean = jnp.mean(history, axis=0)
    prior = jnp.stack([state.filtered[0] + timestep * state.filtered[1], state.filtered[1]])
    return history, prior + jnp.asarray(kalman_gain(config, timestep)) @ (mean - prior)


def start(
    config: SensorConfig, key: PRNGKeyArray, noise: Float[Array, ""], speed: Float[Array, ""]
) -> SensorState:
    """Instruments at rest on a walker that moves at ``speed`` m/s; biases drawn once."""
    spread = jnp.array([config.velocity_bias, config.acceleration_bias, config.pitch_bias])
    settled = jnp.stack([speed, jnp.zeros_like(speed)])
    return SensorState(
        noise=noise,
        bias=noise * spread * jax.random.normal(key, (3,)),
        last_velocity=speed,
        history=jnp.broadcast_to(settled, (config.mean_window, 2)),
        filtered=settled,
    )


def white(key: PRNGKeyArray) -> Float[Array, "18"]:
    """One tick's noise of every instrument, each of unit variance."""
    return jax.random.normal(key, (18,))


def measure(
    config: SensorConfig,
    timestep: float,
    state: SensorState,
    readings: Readings,
    noise: Float[Array, "18"],
) -> tuple[SensorState, Estimate]:
    """One tick of every instrument; ``noise`` is of `white`."""
    white = state.noise * noise
    velocity = readings.velocity[0]
    acceleration = (velocity - state.last_velocity) / timestep
    measured = jnp.stack(
        [
            velocity + state.bias[0] + config.velocity_std * white[0],
            acceleration + state.bias[1] + config.acceleration_std * white[1],
        ]
    )
    history, filtered = filter_step(config, timestep, state, measured)
    pitch = jnp.arctan2(readings.up[0], readings.up[2])
    estimate = Estimate(
        speed=filtered[0],
        acceleration=filtered[1],
        pitch=pitch + state.bias[2] + config.pitch_std * white[2],
        pitch_rate=readings.gyro[1] + config.gyro_std * white[3],
        joints=readings.joints + config.encoder_std * white[4:10].reshape(2, 3),
        joint_rates=readings.joint_rates + config.encoder_rate_std * white[10:16].reshape(2, 3),
        touch=readings.touch + config.touch_std * white[16:18],
    )
    return state.replace(last_velocity=velocity, history=history, filtered=filtered), estimate


def com_ahead(
    body: Skeleton, estimate: Estimate, stance: Float[Array, "2"] | Bool[Array, "2"]
) -> tuple[Float[Array, ""], Float[Array, ""]]:
    """(x ahead of the stance ankle, z above its sole) of the torso's centre, m.

    It stands for the body's centre of mass, as in the paper.

    Args:
      stance: [2] true for the stance leg.
    """
    x, z = ankles(body, estimate.joints, estimate.pitch)
    foot_x, foot_z = jnp.sum(jnp.where(stance, x, 0.0)), jnp.sum(jnp.where(stance, z, 0.0))
    ahead = body.torso * jnp.sin(estimate.pitch) - foot_x
    return ahead, body.torso * jnp.cos(estimate.pitch) - foot_z + body.foot


def zmp_distance(
    body: Skeleton, estimate: Estimate, stance: Float[Array, "2"] | Bool[Array, "2"]
) -> Float[Array, ""]:
    """d_zmp, m: how far the zero-moment point lies ahead of the stance ankle.

    Cart-table model (eq. 4): y_zmp = y_com - (y_com'' / g) z_com.

    Args:
      stance: [2] true for the stance leg.
    """
    com_x, com_z = com_ahead(body, estimate, stance)
    return com_x - estimate.acceleration / GRAVITY * com_z
