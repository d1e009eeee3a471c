"""The step that is planned, against numbers worked by hand."""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.config import CompliantConfig, GaitConfig, StepPlanConfig
from jaxwalk.control.compliant import stance, step_plan
from jaxwalk.control.person import Person
from jaxwalk.control.posture import Posture
from jaxwalk.control.sensors import Estimate
from jaxwalk.control.step_clock import StepClock
from jaxwalk.model.kinematics import Skeleton

NUMBERS = GaitConfig(
    length_nominal=0.8, duration_nominal=0.6, length_min=-0.5, length_max=1.0, duration_min=0.2,
    duration_max=0.9, compliant=CompliantConfig(landing_time=0.6, landing_capture=0.4),
    step_plan=StepPlanConfig(
        length_gain=0.5, pitch_gain=0.3, pitch_least=0.0, duration_gain=0.5, length_least=0.15,
        duration_least=0.3, duration_most=0.7, back_margin=0.02, back_reach=0.05, back_gain=1.5,
        back_least=0.1, back_speed=3.0,
        back_time=0.2, back_soonest=0.04,
    ),
)  # fmt: skip
ROOT = float(np.sqrt(9.81))  # w0 of a hip 1 m high


def f(value):
    return jnp.float32(value)


def planned(elapsed=0.3, ahead=None, at=0.2, swing=-0.3, pitch=0.0, leg=0, numbers=NUMBERS, size=1.0):
    """(length, duration) that is planned; by default with the capture point where it is in steady walking.

    Args:
      ahead: of the capture point before the stance ankle; at, swing: of the ankles before the hip, m.
      leg: that stands. size: of the walker; all of the above are then the reference body's.
    """
    time = size**0.5
    usual = 0.4 * np.exp(-ROOT * max(0.6 - elapsed, 0.0))
    ankles = [at, swing] if leg == 0 else [swing, at]
    where = Posture(
        thigh=jnp.zeros(2), shank=jnp.zeros(2), drop=size * jnp.ones(2), ankle=size * jnp.array(ankles),
        capture=f(size * (at + (usual if ahead is None else ahead))),
    )  # fmt: skip
    clock = StepClock(
        stance=jnp.int32(leg), elapsed=f(time * elapsed), length=f(0), duration=f(0), toe_off=f(0),
        toe_off_seconds=f(0), lag=f(0),
    )  # fmt: skip
    estimate = Estimate(
        speed=f(1), acceleration=f(0), pitch=f(pitch), pitch_rate=f(0), joints=jnp.zeros((2, 3)),
        joint_rates=jnp.zeros((2, 3)), touch=jnp.zeros(2),
    )  # fmt: skip
    body = Skeleton(thigh=f(0.45 * size), shank=f(0.45 * size), foot=f(0.1 * size), torso=f(0.3 * size))
    error = stance.capture_error(numbers, body, clock, where)
    return np.asarray(step_plan.planned(numbers, clock, where, estimate, error))


@pytest.mark.parametrize("elapsed", [0.0, 0.3, 0.59])
def test_a_steady_step_stays_as_it_is_at_any_time(elapsed):
    np.testing.assert_allclose(planned(elapsed), [0.8, 0.6], atol=1e-5)


def will_be(metres, elapsed=0.3):
    """How far the capture point is ahead now, if it will be ``metres`` too far at the landing."""
    return (0.4 + metres) * np.exp(-ROOT * (0.6 - elapsed))


@pytest.mark.parametrize(
    "error, step",
    [
        (0.1, (0.85, 0.55)),  # longer by half of it, sooner by half a second a metre
        (-0.1, (0.75, 0.65)),
        (0.8, (1.2, 0.3)),  # as soon as can be
        (-0.3, (0.65, 0.7)),  # as late as can be
    ],
)
def test_a_step_is_sooner_the_further_ahead_the_capture_point_will_be(error, step):
    np.testing.assert_allclose(planned(0.3, will_be(error)), step, atol=1e-5)


def test_a_step_ahead_is_no_shorter_than_can_be():
    back = dataclasses.replace(NUMBERS.step_plan, length_gain=2.0)
    shrunk = dataclasses.replace(NUMBERS, step_plan=back)
    np.testing.assert_allclose(planned(0.3, will_be(-0.35), numbers=shrunk)[0], 0.15, atol=1e-6)


def test_a_torso_that_leans_forward_makes_it_longer():
    np.testing.assert_allclose(planned(pitch=0.2), [0.86, 0.6], atol=1e-5)


def test_one_that_leans_back_makes_it_no_shorter_than_told():
    plan = dataclasses.replace(NUMBERS.step_plan, pitch_least=-0.1)
    told = planned(pitch=-0.2), planned(pitch=-0.2, numbers=dataclasses.replace(NUMBERS, step_plan=plan))
    np.testing.assert_allclose(told, [[0.8, 0.6], [0.77, 0.6]], atol=1e-5)


@pytest.mark.parametrize("leg", [0, 1])
def test_a_body_that_falls_backward_puts_the_foot_behind_the_other(leg):
    """The capture point is 0.1 m behind the stance ankle, that 0.2 m behind the hip: 1.5 x -0.3 - 0.05."""
    step = planned(0.3, ahead=-0.1, at=-0.2, swing=-0.2, leg=leg)
    np.testing.assert_allclose(step, [-1.0, 0.3 + 0.1], atol=1e-5)  # 0.3 m to go at 3 m/s
    far = planned(0.3, ahead=-0.1, at=-0.2, swing=0.7, leg=leg)
    np.testing.assert_allclose(far, [-1.0, 0.3 + 0.2], atol=1e-5)  # 1.2 m, and no longer than this
    for there in (-0.5, -0.9):  # at its place, or beyond it: it only has to be put down
        near = planned(0.3, ahead=-0.1, at=-0.2, swing=there, leg=leg)
        np.testing.assert_allclose(near, [-1.0, 0.3 + 0.04], atol=1e-5)


def test_it_is_put_some_way_behind_the_stance_ankle_at_least():
    """1.5 x 0.3 - 0.05 is 0.4 m ahead of the hip, where the stance ankle is: 0.1 m behind that."""
    step = planned(0.3, ahead=-0.1, at=0.4, swing=0.6)
    np.testing.assert_allclose(step, [0.6, 0.3 + 0.1], atol=1e-5)


@pytest.mark.parametrize("ahead, back", [(-0.019, False), (-0.021, True)])
def test_it_is_a_step_back_beyond_a_margin(ahead, back):
    assert (planned(0.3, ahead, at=0.0)[0] < 0) == back


@pytest.mark.parametrize("size", [0.81, 1.21])
@pytest.mark.parametrize(
    "told",
    [{}, {"ahead": 0.25}, {"ahead": 0.1, "pitch": 0.2}, {"ahead": -0.1}, {"ahead": -0.1, "swing": 0.1}],
)
def test_similar_bodies_plan_similar_steps(size, told):
    """Lengths as the stature, times as its root, who are asked for similar speeds."""
    asked = dataclasses.replace(NUMBERS, speed_desired=size**0.5)
    numbers = Person.of(asked, f(1.8 * size), f(60.0)).gait
    own = planned(**told, numbers=numbers, size=size)
    np.testing.assert_allclose(own, planned(**told) * [size, size**0.5], rtol=1e-5)


@pytest.mark.parametrize(
    "plan, change, step",
    [
        ((0.7, 0.5), (0.0, 0.0), (0.7, 0.5)),
        ((0.7, 0.5), (-0.2, 0.1), (0.5, 0.6)),
        ((0.9, 0.3), (0.25, -0.15), (1.0, 0.2)),  # within what can be commanded
        ((-0.4, 0.8), (-0.25, 0.15), (-0.5, 0.9)),
        ((1.5, 0.5), (0.0, 0.0), (1.0, 0.5)),
        # The time of a step back is not cut: what is left of it is what it has.
        ((-0.4, 1.2), (0.0, 0.0), (-0.4, 1.2)),
        ((-0.4, 1.2), (0.0, 0.15), (-0.4, 1.2)),
        ((-0.4, 1.2), (0.0, -0.15), (-0.4, 1.05)),
        ((-0.4, 9.0), (0.0, 0.0), (-0.4, 3.0)),
    ],
)
def test_a_policys_change_is_added_within_what_can_be_commanded(plan, change, step):
    found = step_plan.changed(NUMBERS, jnp.array(plan), jnp.array(change))
    np.testing.assert_allclose(found, step, atol=1e-6)
