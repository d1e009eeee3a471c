"""The leg that stands, against numbers worked by hand."""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.config import CompliantConfig, GaitConfig
from jaxwalk.control import posture
from jaxwalk.control.compliant import stance
from jaxwalk.control.sensors import Estimate
from jaxwalk.control.step_clock import Path, StepClock
from jaxwalk.model.kinematics import Skeleton

LEGS = CompliantConfig(
    hip_damping=200.0, pitch_nominal=0.1, pitch_offset=0.02, pitch_capture_gain=0.5, hip_rate_max=3.0,
    hip_speed_min=0.2, knee_stiffness=500.0, knee_damping=20.0, knee_loading=0.4, knee_standing=0.2,
    knee_seconds=0.2, ankle_stiffness=300.0, ankle_slack=0.1, ankle_damping=5.0, ankle_capture_gain=100.0,
    push_off_angle=0.2, push_off_ramp=0.1, push_off_torque=100.0, push_off_gain=200.0, push_off_share=1.0,
    push_off_ankle=0.3, landing_time=0.6, landing_capture=0.4, balance_ankle=0.5, balance_sole=0.2,
    ankle_stop=200.0, ankle_end=0.8, length_speed=0.0, duration_speed=0.2, capture_speed=0.1,
    push_off_speed=0.0, lag_seconds=2.0, lag_speed=0.4, lag_most=0.5, lag_push_off=60.0, lag_pitch=0.2,
    lag_capture=0.3,
)  # fmt: skip
NUMBERS = GaitConfig(compliant=LEGS, speed_desired=1.0)
BODY = Skeleton(
    thigh=jnp.float32(0.45), shank=jnp.float32(0.45), foot=jnp.float32(0.1), torso=jnp.float32(0.3)
)
ROOT = float(np.sqrt(9.81))  # w0 of a hip 1 m high


def f(value):
    return jnp.float32(value)


def clock(elapsed=0.1, stance=0, length=0.6, duration=0.6, lag=0.0):
    return StepClock(
        stance=jnp.int32(stance), elapsed=f(elapsed), length=f(length), duration=f(duration), toe_off=f(0),
        toe_off_seconds=f(0.1), path=Path(f(0), f(0)), lag=f(lag),
    )  # fmt: skip


def estimate(speed=1.0, pitch=0.0, pitch_rate=0.0, left=(0.0, 0.0, 0.0), right=(0.0, 0.0, 0.0), rates=None):
    return Estimate(
        speed=f(speed), acceleration=f(0), pitch=f(pitch), pitch_rate=f(pitch_rate),
        joints=jnp.array([left, right], jnp.float32),
        joint_rates=jnp.zeros((2, 3)) if rates is None else jnp.array(rates, jnp.float32),
        touch=jnp.zeros(2),
    )  # fmt: skip


def where(seen):
    return posture.of(BODY, seen)


@pytest.mark.parametrize(
    "elapsed, angle, rate, torque",
    [
        (0.0, 0.4, 0.0, 0.0),  # at rest at the flexion of loading
        (0.0, 0.3, 1.0, 500 * 0.1 - 20),
        (0.1, 0.3, 0.0, 0.0),  # half way: (0.4 + 0.2) / 2
        (0.2, 0.3, 0.0, -50.0),
        (0.9, 0.3, 0.0, -50.0),  # and no further
    ],
)
def test_the_knee_is_a_damped_spring_about_a_flexion_that_goes_from_loading_to_standing(
    elapsed, angle, rate, torque
):
    seen = estimate(left=(0, angle, 0), rates=[[0, rate, 0], [0, 9, 0]])
    assert stance.knee(NUMBERS, clock(elapsed), seen) == pytest.approx(torque, abs=1e-3)


@pytest.mark.parametrize(
    "speed, pitch, rate, torque",
    [
        (0.9, 0.12, 0.0, 200 * -1.0),  # a' = 0.9 / 0.9 = 1/s; phi0 off: it turns as the leg does
        (0.9, 0.02, 0.0, 0.0),  # where it shall lean
        (0.9, 0.12, -1.0, 0.0),  # and already turns so
        (0.9, 0.62, 0.0, 200 * -3.0),  # limited
        (-1.0, 0.12, 0.0, 200 * -0.2 / 0.9),  # never slower than 0.2 m/s
    ],
)
def test_the_hip_turns_against_the_pitch(speed, pitch, rate, torque):
    # The leg is vertical whatever the pitch: the hip is flexed by as much.
    seen = estimate(speed, pitch, left=(pitch, 0, 0), rates=[[rate, 0, 0], [0, 0, 0]])
    told = stance.hip(NUMBERS, BODY, clock(), where(seen), seen, f(0))
    assert told == pytest.approx(torque, rel=1e-4, abs=1e-3)


def test_it_leans_further_into_a_step_that_will_be_too_long():
    seen = estimate(0.9, 0.12, left=(0.12, 0, 0))
    told = stance.hip(NUMBERS, BODY, clock(), where(seen), seen, f(0.2))  # 0.1 rad further: at rest there
    assert told == pytest.approx(0.0, abs=1e-3)


def test_the_capture_point_of_steady_walking_is_no_error_at_any_time():
    """It runs away from the foot as exp(w0 t): 0.4 m ahead at 0.6 s is 0.4 exp(-w0 (0.6 - t)) at t."""
    for elapsed in (0.0, 0.3, 0.6, 0.8):
        ahead = 0.4 * np.exp(-ROOT * max(0.6 - elapsed, 0.0))
        seen = estimate(speed=ahead * ROOT)  # upright over a vertical leg: v / w0 ahead
        found = stance.capture_error(NUMBERS, BODY, clock(elapsed), where(seen))
        assert found == pytest.approx(0.0, abs=1e-5)


def test_a_push_is_told_as_what_it_makes_of_the_landing():
    seen = estimate(speed=0.5 * ROOT)
    found = stance.capture_error(NUMBERS, BODY, clock(0.5), where(seen))
    assert found == pytest.approx(0.5 * np.exp(ROOT * 0.1) - 0.4, rel=1e-5)


def leaning(behind, speed=1.0, ankle=0.0, rate=0.0):
    """A straight left leg ``behind`` rad behind the vertical."""
    return estimate(speed, left=(-behind, 0.0, ankle), rates=[[0, 0, rate], [0, 0, 0]])


@pytest.mark.parametrize(
    "seen, torque",
    [
        (leaning(0.1), 0.0),  # before push-off, within the slack
        (leaning(0.1, ankle=0.2), -30.0),  # 300 x 0.1: the spring
        (leaning(0.1, rate=2.0), -10.0),
        (leaning(0.25), -50.0),  # half way up the ramp
        (leaning(0.4), -100.0),
        (leaning(0.4, speed=0.8), -140.0),  # 200 for each m/s
        (leaning(0.4, speed=2.0), 0.0),  # never a pull
        (leaning(0.4, ankle=-0.31), 0.0),  # at the ankle's end
        (leaning(-0.3, speed=0.2), 0.0),  # the capture point is behind the foot: no push back
    ],
)
def test_the_ankle_springs_then_pushes_off_behind_the_vertical(seen, torque):
    told = stance.ankle(NUMBERS, clock(), where(seen), seen, f(0))
    assert told == pytest.approx(torque, abs=2e-2)


def test_the_ankle_moves_the_centre_of_pressure_under_the_capture_point():
    seen = leaning(0.1)
    told = stance.ankle(NUMBERS, clock(), where(seen), seen, f(0.3))
    assert told == pytest.approx(-30.0, abs=1e-3)


@pytest.mark.parametrize(
    "ankle, error, torque",
    [
        (-0.3, 0.3, -30.0),  # whole up to 0.4 of plantarflexion
        (-0.45, 0.3, -15.0),  # and none from 0.5 on
        (-0.6, 0.3, 0.0),
        (-0.6, -0.3, 30.0),  # back under the heel at any angle
        (-0.9, 0.3, 20.0),  # 200 x 0.1: the ankle's end
    ],
)
def test_balancing_by_the_toes_ends_before_the_leg_vaults(ankle, error, torque):
    seen = leaning(0.1, ankle=ankle)
    told = stance.ankle(NUMBERS, clock(), where(seen), seen, f(error))
    assert told == pytest.approx(torque, abs=1e-2)


@pytest.mark.parametrize(
    "ankle, torque",
    [
        (0.2, 0.0),  # the toes 0.1 rad up: 30 against the spring's 30
        (0.25, 15.0 - 45.0),  # half
        (0.35, -75.0),  # the spring alone
    ],
)
def test_balancing_by_the_heel_ends_before_the_foot_turns_up(ankle, torque):
    seen = leaning(0.1, ankle=ankle)
    told = stance.ankle(NUMBERS, clock(), where(seen), seen, f(-0.3))
    assert told == pytest.approx(torque, abs=1e-2)


def test_either_leg_may_stand():
    seen = estimate(left=(0, 0.9, 0), right=(0, 0.3, 0))
    assert stance.knee(NUMBERS, clock(0.2, stance=1), seen) == pytest.approx(-50.0, abs=1e-3)


def test_who_is_asked_for_more_has_another_landing_and_push():
    """0.5 m/s more: the landing 0.1 s later, the capture point 0.05 m further ahead; 30 N m s/m of push."""
    legs = dataclasses.replace(LEGS, push_off_speed=30.0)
    quick = dataclasses.replace(NUMBERS, speed_desired=1.5, compliant=legs)
    assert stance.push_off(quick, estimate(1.5), f(0)) == pytest.approx(115.0)
    seen = estimate(1.0)
    ahead = float(where(seen).capture - where(seen).ankle[0])
    error = stance.capture_error(quick, BODY, clock(0.2), where(seen))
    assert error == pytest.approx(ahead * np.exp(ROOT * 0.5) - 0.45, abs=1e-4)


def test_a_slower_walker_pushes_more_and_a_fast_one_not_at_all():
    quick = dataclasses.replace(NUMBERS, speed_desired=1.5)
    assert stance.push_off(quick, estimate(1.0), f(0)) == pytest.approx(200.0)
    assert stance.push_off(NUMBERS, estimate(1.6), f(0)) == 0.0


@pytest.mark.parametrize(
    "speed, lag, after",
    [
        (1.0, 0.0, 0.0),
        (0.7, 0.0, 0.002 * 0.3),
        (0.2, 0.0, 0.002 * 0.4),  # more is not counted
        (2.0, 0.2, 0.2 - 0.002 * (0.4 + 0.1)),  # and it is forgotten in two seconds
        (0.5, 0.5, 0.5),
        (1.5, -0.5, -0.5),
    ],
)
def test_lag_is_the_error_of_the_speed_integrated_with_a_leak(speed, lag, after):
    found = stance.lagging(NUMBERS, clock(lag=lag), estimate(speed), 0.002)
    assert found == pytest.approx(after, abs=1e-6)


def test_who_lags_pushes_more_leans_forward_and_lands_for_it():
    """0.1 m: 6 N m more push, 0.02 rad more lean, the capture point 0.03 m further ahead."""
    seen = estimate()
    assert stance.push_off(NUMBERS, seen, f(0.1)) == pytest.approx(106.0)
    usual = stance.capture_error(NUMBERS, BODY, clock(), where(seen))
    lagging = stance.capture_error(NUMBERS, BODY, clock(lag=0.1), where(seen))
    assert float(lagging) == pytest.approx(float(usual) - 0.03, abs=1e-5)
    leaning = estimate(pitch=0.04)
    torque = stance.hip(NUMBERS, BODY, clock(lag=0.1), where(leaning), leaning, f(0))
    assert torque == pytest.approx(0.0, abs=1e-3)
