"""Probe problems whose values are known in closed form; each names the part that it exercises."""

import functools
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.learn.ddpg import learner, replay_buffer
from jaxwalk.task.transition import Transition

N, UPDATES = 512, 1500


@functools.partial(jax.jit, static_argnums=0)
def _train(config, state, data, key):
    state = learner.observe(state, data.observation, jnp.ones((N,), bool))
    example = jax.tree.map(lambda x: x[0], data)
    ring = replay_buffer.add(replay_buffer.init(N, 1, example), data, jnp.ones((N,), bool))

    def step(state, key):
        bits = jax.random.bits(key, (1, config.batch_size), jnp.uint32)
        keys = jax.random.split(jax.random.fold_in(key, 1), config.batch_size)
        return learner.update(config, state, replay_buffer.sample(ring, bits), keys)

    return jax.lax.scan(step, state, jax.random.split(key, UPDATES))[0]


@pytest.fixture
def solve(config, state):
    """Trains on ``outcome(observation, action) -> reward, discount, next`` of random footsteps, with
    ``changes`` of the learner.

    Returns value(o) of the actor's action there, and action(o); o is the first observation.
    """

    def run(observations, outcome, **changes):
        learns = replace(config, **changes)
        rng = np.random.default_rng(0)
        o = rng.choice(observations, N).astype(np.float32)
        a = rng.uniform(-1, 1, N).astype(np.float32)
        reward, discount, following = (np.broadcast_to(np.float32(x), (N,)) for x in outcome(o, a))
        pad = functools.partial(np.pad, pad_width=((0, 0), (0, 1)))  # the second observation is idle
        data = Transition(pad(o[:, None]), a[:, None], reward, discount, pad(following[:, None]))
        trained = _train(learns, state, jax.tree.map(jnp.asarray, data), jax.random.key(1))
        assert int(trained.metrics.skipped) == 0

        def action(o):
            return learner.act(config, trained, jnp.array([[o, 0.0]]))

        def value(o):
            seen = learner.normalizer.normalize(trained.normalizer, jnp.array([[o, 0.0]]))
            return float(learner._values(config, trained.critic, seen, action(o))[0, 0])

        return value, lambda o: float(action(o)[0, 0])

    return run


def test_constant_reward_is_the_value(solve):
    value, _ = solve([0.0], lambda o, a: (1.0, 0.0, 0.0))
    assert value(0.0) == pytest.approx(1.0, abs=0.05), "critic: loss or optimizer"


def test_reward_depends_on_observation(solve):
    value, _ = solve([-3.0, 3.0], lambda o, a: (o / 3, 0.0, 0.0))
    assert value(3.0) == pytest.approx(1.0, abs=0.1), "critic: does not see the observation"
    assert value(-3.0) == pytest.approx(-1.0, abs=0.1), "critic: does not see the observation"


def test_value_is_discounted_once_and_ends_at_termination(solve):
    # 0 -> 1 -> end; only the second footstep pays, so V(1) = 1 and V(0) = gamma.
    value, _ = solve([0.0, 1.0], lambda o, a: (o, np.where(o == 0, 0.5, 0.0), 1.0))
    assert value(1.0) == pytest.approx(1.0, abs=0.08), "target: termination"
    assert value(0.0) == pytest.approx(0.5, abs=0.08), "target: bootstrap or target networks"


def test_actor_finds_the_best_action(solve):
    value, action = solve([0.0], lambda o, a: (-2 * (a + 0.5) ** 2, 0.0, 0.0))
    assert action(0.0) == pytest.approx(-0.5, abs=0.1), "actor: gradient through the critic"
    assert value(0.0) == pytest.approx(0.0, abs=0.1), "critic: does not see the action"


def test_best_action_depends_on_observation(solve):
    _, action = solve([-1.0, 1.0], lambda o, a: (-2 * (a - o / 2) ** 2, 0.0, 0.0))
    assert action(1.0) == pytest.approx(0.5, abs=0.12), "actor: does not see the observation"
    assert action(-1.0) == pytest.approx(-0.5, abs=0.12), "actor: does not see the observation"


# From 0 on, again and again: an answer a takes 1.5 + 0.5 a units of time, at a discount of a half for each,
# and is paid so that to give it for ever earns BEST - (a + 0.5)^2. Counted by the decision instead, longer
# ones would be taken for better: what one is paid is most at a = -0.3.
GAMMA, BEST = 0.5, 1.6


def _arm(a):
    seconds = 1.5 + 0.5 * a
    return seconds, (BEST - (a + 0.5) ** 2) * (1 - GAMMA**seconds)


def test_decisions_of_unlike_durations_are_held_against_time(solve):
    def outcome(o, a):
        seconds, earned = _arm(a)
        return earned, GAMMA**seconds, 0.0

    value, action = solve([0.0], outcome)
    assert action(0.0) == pytest.approx(-0.5, abs=0.1), "discount: by the decision, not by time"
    assert value(0.0) == pytest.approx(BEST, abs=0.1)


def test_decisions_asked_again_on_the_way_come_to_the_same(solve):
    def outcome(o, a):  # at 1 + a, half way, the rest of a is still to come, whatever is answered
        seconds, earned = _arm(np.where(o == 0, a, o - 3))
        half = earned / (1 + GAMMA ** (seconds / 2))  # paid twice
        return half, GAMMA ** (seconds / 2), np.where(o == 0, 3 + a, 0.0)

    # The actor waits, or it would be at the end of its range before the critic knows the rest of the way.
    value, action = solve([*[0.0] * 9, *np.linspace(2, 4, 9)], outcome, critic_head_start=1000)
    assert action(0.0) == pytest.approx(-0.5, abs=0.15), "discount: by the decision, not by time"
    assert value(0.0) == pytest.approx(BEST, abs=0.15)
