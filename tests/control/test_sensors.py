"""Instruments tell the truth plus what the configuration says, and filters do what textbooks say."""

import dataclasses
import functools

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
import pytest
from scipy.linalg import solve_discrete_are

from jaxwalk.config import BodyConfig, PhysicsConfig, SensorConfig
from jaxwalk.control import sensors
from jaxwalk.model import anthropometry, kinematics, mjcf
from jaxwalk.model.physics import Readings

CONFIG = SensorConfig()
DT = 0.002
SKELETON = kinematics.skeleton(anthropometry.build(BodyConfig()), jnp.float32(1))


def readings(velocity=1.0, pitch=0.0, gyro=0.0):
    return Readings(
        velocity=jnp.array([velocity, 0.0, 0.1]),
        up=jnp.array([np.sin(pitch), 0.0, np.cos(pitch)]),
        gyro=jnp.array([0.0, gyro, 0.0]),
        touch=jnp.array([700.0, 3.0]),
        joints=jnp.array([[0.3, 0.2, -0.1], [-0.2, 0.05, 0.15]]),
        joint_rates=jnp.array([[1.0, -2.0, 0.5], [-1.0, 0.3, 0.0]]),
    )


def start(noise, key=0, speed=1.0, config=CONFIG):
    return sensors.start(config, jax.random.key(key), jnp.float32(noise), jnp.float32(speed))


@functools.partial(jax.jit, static_argnums=0)
def filtered(config, state, signal):
    """[T, 2] what the filters make of [T, 2] (velocity, acceleration)."""

    def tick(state, measured):
        history, after = sensors.filter_step(config, DT, state, measured)
        return state.replace(history=history, filtered=after), after

    return jax.lax.scan(tick, state, signal)[1]


def test_without_noise_the_instruments_tell_the_truth():
    truth = readings(velocity=1.3, pitch=0.2, gyro=-0.4)
    state, estimate = sensors.measure(
        CONFIG, DT, start(0.0, speed=1.3), truth, sensors.white(jax.random.key(1))
    )
    assert not state.bias.any()
    assert estimate.pitch == pytest.approx(0.2, abs=1e-6)
    assert estimate.pitch_rate == pytest.approx(-0.4)
    for name in ("touch", "joints", "joint_rates"):
        np.testing.assert_array_equal(getattr(estimate, name), getattr(truth, name))
    # The speed has been 1.3 m/s all along: nothing to filter away.
    assert estimate.speed == pytest.approx(1.3)
    assert estimate.acceleration == pytest.approx(0.0, abs=1e-5)


@pytest.mark.parametrize("scale", [1.0, 2.0])
def test_noise_has_the_configured_spread(scale):
    count, truth = 20_000, readings()
    state = dataclasses.replace(start(scale), bias=jnp.zeros(3))
    keys = jax.random.split(jax.random.key(2), count)
    measured, told = jax.jit(
        jax.vmap(lambda key: sensors.measure(CONFIG, DT, state, truth, sensors.white(key)))
    )(keys)
    seen = {
        "pitch_std": told.pitch,
        "gyro_std": told.pitch_rate,
        "encoder_std": told.joints - truth.joints,
        "encoder_rate_std": told.joint_rates - truth.joint_rates,
        "touch_std": told.touch - truth.touch,
        "velocity_std": measured.history[:, -1, 0] - 1.0,
        "acceleration_std": measured.history[:, -1, 1],
    }
    for name, sample in seen.items():
        std = scale * getattr(CONFIG, name)
        # A spread from 20,000 samples errs by 1 / sqrt(2 x 20,000) = 0.5 %; four of those. The mean
        # errs by 0.7 % of a spread; five of those.
        np.testing.assert_allclose(np.std(sample, axis=0), std, rtol=0.02, err_msg=name)
        np.testing.assert_allclose(np.mean(sample, axis=0), 0.0, atol=0.035 * std, err_msg=name)


def test_biases_differ_between_walkers_and_last():
    keys = jax.random.split(jax.random.key(3), 20_000)
    states = jax.vmap(lambda key: sensors.start(CONFIG, key, jnp.float32(1), jnp.float32(1)))(keys)
    expected = [CONFIG.velocity_bias, CONFIG.acceleration_bias, CONFIG.pitch_bias]
    np.testing.assert_allclose(states.bias.std(0), expected, rtol=0.02)  # as above

    calm = dataclasses.replace(CONFIG, pitch_std=0.0, velocity_std=0.0, acceleration_std=0.0)
    state = start(1.0, config=calm)
    for tick in range(3):
        after, told = sensors.measure(
            calm, DT, state, readings(pitch=0.1), sensors.white(jax.random.key(tick))
        )
        assert told.pitch == pytest.approx(0.1 + float(state.bias[2]), abs=1e-6)
        assert after.history[-1, 0] == pytest.approx(1.0 + float(state.bias[0]))
        np.testing.assert_array_equal(after.bias, state.bias)
        state = after


def test_instruments_do_not_share_their_noise():
    keys = jax.random.split(jax.random.key(4), 20_000)
    state = start(1.0)
    told = jax.vmap(lambda key: sensors.measure(CONFIG, DT, state, readings(), sensors.white(key))[1])(keys)
    columns = [told.pitch, told.pitch_rate, told.speed, *told.touch.T]
    columns += [*told.joints.reshape(-1, 6).T, *told.joint_rates.reshape(-1, 6).T]
    correlation = np.corrcoef(np.array(columns)) - np.eye(len(columns))
    assert np.abs(correlation).max() < 0.035  # chance gives 1 / sqrt(20,000) = 0.007; five of those


def test_the_kalman_gain_solves_the_riccati_equation():
    advance = np.array([[1.0, DT], [0.0, 1.0]])
    drift = np.array([DT / 2, 1.0]) * CONFIG.kalman_process
    error = np.diag([CONFIG.kalman_velocity**2, CONFIG.kalman_acceleration**2])
    # Estimation is the dual of control: A and H (here 1) enter transposed.
    prior = solve_discrete_are(advance.T, np.eye(2), np.outer(drift, drift), error)
    gain = prior @ np.linalg.inv(prior + error)
    np.testing.assert_allclose(sensors.kalman_gain(CONFIG, DT), gain, rtol=1e-5)


def test_filters_leave_a_constant_speed_alone():
    signal = jnp.broadcast_to(jnp.array([1.2, 0.0]), (500, 2))
    np.testing.assert_allclose(filtered(CONFIG, start(0.0, speed=1.2), signal), signal, atol=1e-5)


def test_a_ramp_is_followed_half_a_window_late():
    time = DT * jnp.arange(2000)
    slope = 1.5
    signal = jnp.stack([slope * time, jnp.full_like(time, slope)], axis=1)
    told = np.asarray(filtered(CONFIG, start(0.0, speed=0.0), signal))
    # The mean of the last N lies (N - 1) / 2 ticks back; the Kalman filter's own model is a ramp, so
    # that it adds no lag once settled.
    late = slope * DT * (CONFIG.mean_window - 1) / 2
    np.testing.assert_allclose(told[-100:, 0], signal[-100:, 0] - late, atol=1e-3)
    np.testing.assert_allclose(told[-100:, 1], slope, atol=1e-3)


def test_a_step_is_answered_as_by_a_textbook_filter():
    """Mean of the last N, then predict-and-correct with the time-varying covariance, settled."""
    signal = np.zeros((300, 2))
    signal[20:, 1] = 2.0
    signal[20:, 0] = 2.0 * DT * np.arange(280)
    advance = np.array([[1.0, DT], [0.0, 1.0]])
    drift = np.array([DT / 2, 1.0]) * CONFIG.kalman_process
    error = np.diag([CONFIG.kalman_velocity**2, CONFIG.kalman_acceleration**2])
    covariance, settled = np.eye(2), 5000
    state, expected = np.zeros(2), []
    padded = np.concatenate([np.zeros((CONFIG.mean_window - 1, 2)), signal])
    for tick in range(-settled, len(signal)):
        state, covariance = advance @ state, advance @ covariance @ advance.T + np.outer(drift, drift)
        gain = covariance @ np.linalg.inv(covariance + error)
        mean = padded[tick : tick + CONFIG.mean_window].mean(0) if tick >= 0 else np.zeros(2)
        state, covariance = state + gain @ (mean - state), (np.eye(2) - gain) @ covariance
        if tick >= 0:
            expected.append(state)
    told = filtered(CONFIG, start(0.0, speed=0.0), jnp.asarray(signal, jnp.float32))
    np.testing.assert_allclose(told, expected, atol=1e-5)  # float32
    assert 0.1 < expected[24][1] < 1.9  # the signal is on its way, not already there


def test_filters_pass_less_noise_than_they_get():
    noise = jax.random.normal(jax.random.key(5), (5000, 2)) * jnp.array([0.03, 0.3])
    told = filtered(CONFIG, start(0.0, speed=0.0), noise)
    # A mean of 10 alone divides the spread by 3.2; what the Kalman filter infers from one signal about
    # the other may add to it again.
    assert (np.std(told[500:], 0) < 0.5 * np.std(noise, 0)).all()


def test_the_accelerometer_reads_what_mujocos_does():
    spec = mjcf.build(anthropometry.build(BodyConfig()), PhysicsConfig(iterations=100))
    spec.add_sensor(
        name="accelerometer",
        type=mujoco.mjtSensor.mjSENS_ACCELEROMETER,
        objtype=mujoco.mjtObj.mjOBJ_SITE,
        objname="imu",
    )
    model = spec.compile()
    data = mujoco.MjData(model)
    # In the air, with smoothly moving limbs: the servos lie at their set points.
    data.qpos[:] = [0, 3, 0.1, 0.4, 0.3, 0.1, -0.3, 0.1, 0.2]
    data.ctrl[1], data.ctrl[4] = 0.3, 0.1
    ours, theirs = [], []
    state = start(0.0, speed=0.0)
    for tick in range(60):
        data.xfrc_applied[1, 0] = 300 * np.sin(0.05 * tick)  # a push that swells and ebbs
        mujoco.mj_step(model, data)
        sensed = data.sensor("imu_velocity").data, data.sensor("imu_up").data, data.sensor("imu_gyro").data
        pitch = np.arctan2(sensed[1][0], sensed[1][2])
        truth = readings().replace(
            velocity=jnp.float32(sensed[0]), up=jnp.float32(sensed[1]), gyro=jnp.float32(sensed[2])
        )
        state, _ = sensors.measure(CONFIG, DT, state, truth, sensors.white(jax.random.key(0)))
        ours.append(float(state.history[-1, 1]))
        x, _, z = data.sensor("accelerometer").data  # specific force, torso frame
        theirs.append(np.cos(pitch) * x + np.sin(pitch) * z)  # forward: gravity has no part in it
    # Ours is the mean over the tick before; the push's swelling in one tick is 15 N of about 51 kg,
    # 0.3 m/s^2, and float32 velocities divided by 2 ms are good to 1e-3.
    np.testing.assert_allclose(ours[2:], theirs[1:-1], atol=0.1)
    assert max(theirs) > 3.0


def test_zmp_lies_under_a_body_at_rest_and_behind_one_that_speeds_up():
    stance = jnp.array([True, False])

    def told(acceleration, pitch=0.0):
        joints = jnp.array([[0.2 + pitch, 0.0, -0.2], [0.0, 0.0, 0.0]])
        zero = jnp.zeros(())
        estimate = sensors.Estimate(
            speed=zero, acceleration=jnp.float32(acceleration), pitch=jnp.float32(pitch), pitch_rate=zero,
            joints=joints, joint_rates=jnp.zeros((2, 3)), touch=jnp.zeros(2),
        )  # fmt: skip
        return sensors.zmp_distance(SKELETON, estimate, stance)

    # The leg, 0.8838 m from hip to ankle, points 0.2 rad forward: ankle 0.8838 sin 0.2 = 0.17558 m
    # ahead of the hip and of the torso's centre above it.
    assert told(0.0) == pytest.approx(-0.17558, abs=2e-5)
    # Centre above the floor: 0.32452 + 0.8838 cos 0.2 + 0.0702 = 1.26090 m; at 1 m/s^2 the point
    # moves back by 1.26090 / 9.81 = 0.12853 m.
    assert told(1.0) - told(0.0) == pytest.approx(-0.12853, abs=2e-5)
    assert told(-2.0) - told(0.0) == pytest.approx(2 * 0.12853, abs=4e-5)
    # Leaning by 0.1 rad with the leg where it was moves the centre by 0.32452 sin 0.1 = 0.03240 m.
    assert told(0.0, 0.1) - told(0.0) == pytest.approx(0.03240, abs=2e-5)
    assert SKELETON.leg == pytest.approx(0.954, abs=1e-4)
