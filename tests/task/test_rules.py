"""The footstep rules, in numbers worked by hand, and as policies."""

from __future__ import annotations

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.config import GRAVITY
from jaxwalk.learn.policies import named
from jaxwalk.options import checks
from jaxwalk.task import footstep, rules
from jaxwalk.task.rules import CapturePoint, Constant, Raibert

# A pendulum of one rad/s whose step makes the offset three times as large: b0 = 0.4 / (3 - 1) = 0.2 m.
SLOW = {"height": GRAVITY, "seconds": math.log(3.0), "step": 0.4, "com_ahead": -0.2, "landing_speed": 1.2}
ASK = {"length": 0.6, "duration": 0.1, "length_gain": 1.0, "duration_gain": 1.0}


def seen(speed, ahead, desired=1.0):
    return jnp.array([speed, desired, ahead], jnp.float32)


def test_the_constant_step_answers_nothing():
    rule = Constant(length=0.7, duration=0.09)
    assert rule.command(seen(1.0, -0.2)).tolist() == rule.command(seen(2.0, 0.3)).tolist()
    assert rule.command(seen(1.0, -0.2)).tolist() == pytest.approx([0.7, 0.09])


def test_raibert_steps_longer_by_the_error_of_speed():
    rule = Raibert(length=0.6, duration=0.1, gain=0.3, landing_speed=1.2)
    assert rule.command(seen(1.2, 0.0)).tolist() == pytest.approx([0.6, 0.1])
    assert rule.command(seen(1.4, 0.0)).tolist() == pytest.approx([0.66, 0.1])
    assert rule.command(seen(0.6, 0.0, desired=0.8)).tolist() == pytest.approx([0.492, 0.1])  # 0.36 too slow


@pytest.mark.parametrize("timing", [0.01, 1.0, 100.0])
def test_who_lands_as_usual_steps_as_usual(timing):
    rule = CapturePoint(**SLOW, **ASK, timing=timing)
    assert rule.command(seen(1.2, -0.2)).tolist() == pytest.approx([0.6, 0.1], abs=1e-6)


def test_half_of_a_capture_point_s_error_is_position_and_half_speed():
    rule = CapturePoint(**SLOW, **ASK)  # omega is 1: 0.1 m and 0.1 m/s weigh alike
    np.testing.assert_allclose(rule.command(seen(1.3, -0.2)), rule.command(seen(1.2, -0.1)), atol=1e-5)


def test_a_step_that_may_not_change_its_time_is_longer():
    """b = 0.3: 0.3 x 3 - L = 0.2, so L = 0.7, 0.3 m longer than usual."""
    rule = CapturePoint(**SLOW, **ASK, timing=1e9)
    assert rule.command(seen(1.2, -0.1)).tolist() == pytest.approx([0.9, 0.1], abs=1e-5)


def test_a_step_that_may_not_change_its_length_is_sooner():
    """b = 0.3: 0.3 tau - 0.4 = 0.2, so tau = 2, and T = ln 2 instead of ln 3."""
    rule = CapturePoint(**SLOW, **ASK, timing=0.0)
    assert rule.command(seen(1.2, -0.1)).tolist() == pytest.approx([0.6, 0.1 - math.log(1.5)], abs=1e-5)


@pytest.mark.parametrize("error", [-0.1, 0.05, 0.3])
@pytest.mark.parametrize("timing", [0.05, 1.0, 20.0])
def test_the_next_step_begins_as_usual_and_no_other_is_nearer(error, timing):
    """The pendulum itself, run for the time asked for, and every other step that does the same."""
    rule = CapturePoint(**SLOW, **ASK, timing=timing)
    length, duration = rule.command(seen(1.2, -0.2 + error))
    step, seconds = float(length) - 0.2, float(duration) - 0.1 + math.log(3.0)
    assert (0.2 + error) * math.exp(seconds) - step == pytest.approx(0.2, abs=1e-5)

    def price(tau):
        return (((0.2 + error) * tau - 0.6) / 0.4) ** 2 + timing * ((tau - 3.0) / 3.0) ** 2

    assert price(math.exp(seconds)) <= price(np.linspace(1.0, 6.0, 5001)).min() + 1e-6


def test_a_capture_point_far_behind_the_foot_asks_for_nothing_that_is_not_finite():
    rule = rules.RULES["capture-point"]
    asked = jax.vmap(rule.command)(jax.vmap(seen)(jnp.linspace(-3, 4, 50), jnp.linspace(-1, 1, 50)))
    assert bool(jnp.isfinite(asked).all())


@pytest.mark.parametrize("name", ["constant", "raibert", "capture-point"])
def test_actions_stand_for_the_commands_within_their_bounds(name):
    subject = named.load(name)
    assert (subject.config.observation, subject.config.task.replan) == (rules.OBSERVATION, 0)
    assert subject.config.gait.steps == "told"
    who = rules.reference(subject.config.gait)
    low, high = footstep.bounds(who)
    for observation in (seen(1.2, -0.2), seen(1.5, -0.1), seen(9.0, 2.0), seen(-9.0, -2.0)):
        action = jax.jit(subject.act)(subject.params, observation)
        wanted = jnp.clip(rules.RULES[name].command(observation), low, high)
        np.testing.assert_allclose(footstep.to_command(who, action), wanted, atol=1e-5)


def test_replan_leaves_the_planned_step_as_it_is():
    subject = named.load("replan")
    assert (subject.config.gait.steps, subject.config.task.replan) == ("planned", 0)
    who = rules.reference(subject.config.gait)
    for observation in (seen(1.2, -0.2), seen(9.0, 2.0), seen(-9.0, -2.0)):
        change = footstep.to_command(who, jax.jit(subject.act)(subject.params, observation))
        assert change.tolist() == [0.0, 0.0]


def test_the_fixed_step_is_the_nominal_one():
    subject = named.load("fixed")
    gait = subject.config.gait
    assert gait.steps == "told"
    step = footstep.to_command(rules.reference(gait), subject.act(subject.params, seen(1.2, -0.2)))
    np.testing.assert_allclose(step, [gait.length_nominal, gait.duration_nominal], atol=1e-6)


def test_every_rule_has_a_name_on_the_command_line_and_no_two_act_alike():
    assert set(rules.RULES) < set(checks.BUILT_IN)
    digests = {named.load(name).digest for name in checks.BUILT_IN}
    assert len(digests) == len(checks.BUILT_IN)
