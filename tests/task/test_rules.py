"""The footstep rules, in numbers worked by hand, and as policies."""

from __future__ import annotations

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.config import GRAVITY, GaitConfig
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
    who = rules.reference(GaitConfig())
    low, high = footstep.bounds(who)
    for observation in (seen(1.2, -0.2), seen(1.5, -0.1), seen(9.0, 2.0), seen(-9.0, -2.0)):
        action = jax.jit(subject.act)(subject.params, observation)
        wanted = jnp.clip(rules.RULES[name].command(observation), low, high)
        np.testing.assert_allclose(footstep.to_command(who, action), wanted, atol=1e-5)


REPLAN = rules.Replan(
    length=0.8, duration=0.6, capture=0.4, length_gain=0.5, pitch_gain=0.0, duration_gain=0.5,
    length_least=0.15, duration_least=0.3, duration_most=0.7, back_margin=0.02, back_reach=0.05,
    back_gain=1.0, back_least=0.1, back_speed=3.0, back_time=0.2, torso=0.3, leg=0.981,
)  # fmt: skip
ROOT = np.sqrt(10.0)  # w0 of such a leg, 1/s


def replanned(elapsed=0.3, ahead=None, speed=1.0, pitch=0.0, swing=0.0):
    """The rule's answer; by default where the capture point is in steady walking."""
    usual = 0.4 * np.exp(-ROOT * max(0.6 - elapsed, 0.0))
    told = [speed, 1.0, pitch, elapsed, usual if ahead is None else ahead, swing]
    return np.asarray(REPLAN.command(jnp.array(told, jnp.float32)))


@pytest.mark.parametrize("elapsed", [0.0, 0.3, 0.59])
def test_replan_leaves_a_steady_step_as_it_is_whenever_it_is_asked(elapsed):
    np.testing.assert_allclose(replanned(elapsed), [0.8, 0.6], atol=1e-5)


def test_replan_makes_a_step_longer_and_sooner_by_what_a_push_will_have_made_of_it():
    ahead = 0.5 * np.exp(-ROOT * 0.3)  # 0.1 m too far at the landing
    np.testing.assert_allclose(replanned(0.3, ahead), [0.85, 0.55], atol=1e-5)
    np.testing.assert_allclose(replanned(0.3, 0.9)[1], 0.3, atol=1e-6)  # as soon as can be


def test_replan_sends_the_foot_behind_the_one_that_the_body_falls_back_over():
    """The capture point is 0.3162 m ahead of the hip, the stance ankle 0.1 m further."""
    length, duration = replanned(0.3, ahead=-0.1, swing=-0.4)
    place = 1 / ROOT - 0.05  # behind the capture point; that is 0.15 m behind the ankle
    assert length == pytest.approx(2 * place, rel=1e-5)
    assert duration == pytest.approx(0.3 + 0.25 / 3.0, rel=1e-4)  # it has 0.25 m to go
    assert replanned(0.3, ahead=-0.1, swing=1.5)[1] == pytest.approx(0.5)  # and never takes longer than this


def test_replan_sees_what_it_needs_and_is_asked_in_every_window():
    subject = named.load("replan")
    assert (subject.config.observation, subject.config.task.replan) == (rules.REPLANNED, 1)


def test_every_rule_has_a_name_on_the_command_line_and_no_two_act_alike():
    assert set(rules.RULES) < set(checks.BUILT_IN)
    digests = {named.load(name).digest for name in checks.BUILT_IN}
    assert len(digests) == len(checks.BUILT_IN)
