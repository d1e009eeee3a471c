"""What the policy is told, may answer and earns, in numbers worked by hand."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.config import Config, GaitConfig, RewardConfig, SensorConfig, StepPlanConfig
from jaxwalk.control import walker
from jaxwalk.control.person import Person
from jaxwalk.model.burdens import Burden
from jaxwalk.model.engine import Setup
from jaxwalk.task import footstep

NUMBERS = GaitConfig(
    speed_desired=1.0, length_min=0.2, length_max=1.4, duration_min=0.1, duration_max=0.4,
    length_nominal=0.8, duration_nominal=0.175, steps="told",
)  # fmt: skip
PLANNED = GaitConfig(steps="planned", step_plan=StepPlanConfig(change_length=0.2, change_duration=0.1))
SETUP = Setup.of(Config(sensors=SensorConfig(noise=0.0)))
EVERYTHING = (
    "speed", "pitch", "zmp", "step_length", "pitch_rate", "acceleration",
    "speed_desired", "height", "com_ahead",
)  # fmt: skip


def somebody(length_ratio=1.0, mass_ratio=1.0, numbers=NUMBERS):
    return Person.of(numbers, jnp.float32(1.8 * length_ratio), jnp.float32(75 * mass_ratio))


def landed(who, speed=1.0, pitch=0.1, acceleration=0.5, pitch_rate=0.3):
    """A walker with both legs straight, the stance thigh 0.2 rad forward of the vertical.

    Rates and speeds are given for the reference body and scaled to ``who``.
    """
    state = walker.start(SETUP, who, jax.random.key(0), jnp.float32(0))
    ratio = who.ratio
    thighs = jnp.where(state.gait.is_stance, 0.2, -0.3)
    estimate = state.estimate.replace(
        speed=speed * ratio.speed, acceleration=jnp.float32(acceleration), pitch=jnp.float32(pitch),
        pitch_rate=pitch_rate * ratio.rate, joints=jnp.zeros((2, 3)).at[:, 0].set(thighs + pitch),
    )  # fmt: skip
    return state.replace(estimate=estimate)


@pytest.mark.parametrize(
    ("action", "command"),
    [
        ((-1.0, -1.0), (0.2, 0.1)),
        ((1.0, 1.0), (1.4, 0.4)),
        ((0.0, 0.0), (0.8, 0.25)),
        ((0.5, -0.5), (1.1, 0.175)),
        ((7.0, -7.0), (1.4, 0.1)),  # never out of bounds
    ],
)
def test_actions_are_shares_of_the_bounds(action, command):
    told = footstep.to_command(somebody(), jnp.array(action))
    assert told.tolist() == pytest.approx(command)
    # A body 1.21 times as tall: lengths by 1.21, times by 1.1.
    told = footstep.to_command(somebody(1.21, 2.0), jnp.array(action))
    assert told.tolist() == pytest.approx([1.21 * command[0], 1.1 * command[1]])


@pytest.mark.parametrize(
    ("action", "change"),
    [
        ((0.0, 0.0), (0.0, 0.0)),
        ((1.0, -1.0), (0.2, -0.1)),
        ((-0.5, 0.25), (-0.1, 0.025)),
        ((-7.0, 7.0), (-0.2, 0.1)),  # never out of bounds
    ],
)
def test_of_steps_that_are_planned_they_are_shares_of_what_may_be_changed(action, change):
    told = footstep.to_command(somebody(numbers=PLANNED), jnp.array(action))
    assert told.tolist() == pytest.approx(change, abs=1e-7)
    told = footstep.to_command(somebody(1.21, 2.0, PLANNED), jnp.array(action))
    assert told.tolist() == pytest.approx([1.21 * change[0], 1.1 * change[1]], abs=1e-7)


@pytest.mark.parametrize("numbers", [NUMBERS, PLANNED], ids=["told", "planned"])
def test_commands_and_actions_are_each_others_inverse(numbers):
    who = somebody(0.9, 0.7, numbers)
    for action in jax.random.uniform(jax.random.key(0), (20, 2), minval=-1.0):
        again = footstep.to_action(who, footstep.to_command(who, action))
        np.testing.assert_allclose(again, action, atol=1e-5)  # float32


def test_the_nominal_action_is_the_nominal_step_for_every_body():
    # 0.8 m is the middle of 0.2..1.4; 0.175 s is a quarter of 0.1..0.4: -0.5.
    for ratio in (0.8, 1.0, 1.3):
        action = footstep.nominal_action(somebody(ratio, ratio**3))
        assert action.tolist() == pytest.approx([0.0, -0.5], abs=1e-6)
        assert footstep.to_command(somebody(ratio), action).tolist() == pytest.approx(
            [0.8 * ratio, 0.175 * ratio**0.5]
        )


def test_before_learning_a_plan_is_left_as_it_is_by_every_body():
    for ratio in (0.8, 1.0, 1.3):
        who = somebody(ratio, ratio**3, PLANNED)
        assert footstep.to_command(who, footstep.nominal_action(who)).tolist() == [0.0, 0.0]


def test_the_policy_is_told_what_was_asked_for_in_that_order():
    told = footstep.observe(EVERYTHING, SETUP, landed(somebody()), jnp.float32(0.45))
    # d_zmp: the torso's centre, 0.32452 m up its axis, is 0.32452 sin 0.1 = 0.03240 ahead of the hip, the
    # ankle 0.8838 sin 0.2 = 0.17558 m; its height 0.32452 cos 0.1 + 0.8838 cos 0.2 + 0.0702 = 1.25928 m, by
    # 0.5 / 9.81 = 0.06418 m: 0.03240 - 0.17558 - 0.06418 = -0.20737.
    assert told.tolist() == pytest.approx([1.0, 0.1, -0.20737, 0.45, 0.3, 0.5, 1.0, 1.0, -0.14318], abs=3e-5)
    fewer = footstep.observe(("step_length", "pitch"), SETUP, landed(somebody()), jnp.float32(0.45))
    assert fewer.tolist() == pytest.approx([0.45, 0.1])


@pytest.mark.parametrize(("length", "mass"), [(1.3, 2.0), (0.8, 0.5)])
def test_similar_bodies_observe_the_same(length, mass):
    names = ("speed", "pitch", "zmp", "step_length", "pitch_rate", "acceleration", "com_ahead")
    reference = footstep.observe(names, SETUP, landed(somebody()), jnp.float32(0.45))
    told = footstep.observe(names, SETUP, landed(somebody(length, mass)), jnp.float32(0.45 * length))
    np.testing.assert_allclose(told, reference, rtol=1e-5)
    only = footstep.observe(("height",), SETUP, landed(somebody(length, mass)), jnp.float32(0.5))
    assert only.tolist() == pytest.approx([length])


@pytest.mark.parametrize(("length", "told"), [(1.0, 0.02), (1.44, 0.02 / 1.2)])
def test_how_late_instruments_are_is_told_as_the_reference_body_would_feel_it(length, told):
    """Times go as the root of lengths."""
    state = landed(somebody(length))
    burden = Burden(0.0, 0.0, 0.0, 0.0, SETUP.physics.friction, delay=0.02)
    late = state.replace(person=state.person.replace(burden=burden))
    for who, seconds in ((state, 0.0), (late, told)):
        seen = footstep.observe(("delay",), SETUP, who, jnp.float32(0.5))
        assert seen.tolist() == pytest.approx([seconds])


WEIGHTS = RewardConfig(
    speed_weight=1.0, speed_tolerance=0.05, pitch_weight=0.5, zmp_weight=0.1, length_weight=0.2, fall=-5.0
)


def earned(who, speed=1.0, length=0.633, fell=False, pitch=0.1, acceleration=0.5):
    state = landed(who, pitch=pitch, acceleration=acceleration)
    told = jnp.float32(speed), jnp.float32(length), jnp.bool_(fell)
    return float(footstep.reward(WEIGHTS, SETUP, state, *told))


def cost(*args, **changes):
    """The reward is exp(-cost)."""
    return -np.log(earned(*args, **changes))


def test_reward_by_hand():
    # At the desired speed with the usual step of 0.633 m there remain the pitch, 0.5 (0.1 / 0.2)^2 = 0.125,
    # and the ZMP, 0.1 (0.20737 / 0.3)^2 = 0.04778.
    usual = 0.125 + 0.04778
    assert cost(somebody()) == pytest.approx(usual, abs=1e-4)
    # 0.25 m/s too slow: (0.25 / 0.5)^2 = 0.25. 0.15 m too long: 0.2 (0.15 / 0.3)^2 = 0.05.
    assert cost(somebody(), speed=0.7) == pytest.approx(usual + 0.25, abs=1e-4)  # ((0.3 - 0.05) / 0.5)^2
    assert cost(somebody(), speed=1.3) == pytest.approx(usual + 0.25, abs=1e-4)
    assert cost(somebody(), speed=1.04) == pytest.approx(usual, abs=1e-4)
    assert cost(somebody(), length=0.783) == pytest.approx(usual + 0.05, abs=1e-4)
    assert cost(somebody(), length=0.483) == pytest.approx(usual + 0.05, abs=1e-4)
    # Upright: the ZMP is all that is left, at -0.17558 - 0.5 / 9.81 x (0.32452 + 0.86618 + 0.0702).
    assert cost(somebody(), pitch=0.0) == pytest.approx(0.1 * (0.23985 / 0.3) ** 2, abs=1e-4)


@pytest.mark.parametrize(("length", "mass", "speed"), [(1.0, 1.0, 1.0), (1.3, 2.0, 1.0), (1.0, 1.0, 1.4)])
def test_work_costs_by_what_it_moves(length, mass, speed):
    """0.2 J/(N m): twice the scale, so four times the weight."""
    numbers = GaitConfig(speed_desired=speed)
    state = landed(somebody(length, mass, numbers=numbers))
    told = jnp.float32(speed), jnp.float32(0.633), jnp.bool_(False)
    weights = dataclasses.replace(WEIGHTS, work_weight=0.05)
    idle, hard = (
        footstep.reward(weights, SETUP, state.replace(effort=jnp.float32(x)), *told)
        for x in (0.0, 0.2 * 75.0 * mass * 9.81 * speed)
    )
    assert np.log(idle / hard) == pytest.approx(4 * 0.05, rel=1e-4)


def test_a_fall_costs_the_same_however_it_looks():
    for speed, pitch in ((1.0, 0.0), (3.0, 1.2), (-2.0, -1.2)):
        assert earned(somebody(), speed=speed, pitch=pitch, fell=True) == -5.0


def test_to_keep_walking_however_badly_is_better_than_to_fall():
    assert 0.0 <= earned(somebody(), speed=-4.0, pitch=0.9, length=3.0) < earned(somebody()) <= 1.0
    assert earned(somebody(), fell=True) < 0.0


def best_length(who, speed):
    """The step length that earns most at ``speed``."""
    state, lengths = landed(who), jnp.linspace(0.5, 1.0, 501)
    told = jnp.float32(speed), jnp.bool_(False)
    earns = jax.vmap(lambda length: footstep.reward(WEIGHTS, SETUP, state, told[0], length, told[1]))(lengths)
    return float(lengths[jnp.argmax(earns)])


def test_the_usual_step_grows_with_the_body_and_with_speed():
    # Boulic: length goes as the root of speed over hip height, relative to hip height. At 1.44 m/s on
    # the reference body 0.633 x 1.2 = 0.7596 m.
    fast = somebody(numbers=GaitConfig(speed_desired=1.44))
    assert best_length(fast, 1.44) == pytest.approx(0.7596, abs=0.003)
    # 1.21 times as tall at 1 m/s: 0.633 sqrt(1 / 1.1) 1.21 = 0.7303 m.
    assert best_length(somebody(1.21, 1.7), 1.0) == pytest.approx(0.7303, abs=0.003)
