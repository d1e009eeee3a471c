"""Probe problems whose values are known in closed form; each names the part that it exercises."""

import functools

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
    ring = replay_buffer.add(replay_buffer.init(1, N, example), data, jnp.ones((N,), bool))

    def step(state, key):
        bits = jax.random.bits(key, (1, config.batch_size), jnp.uint32)
        keys = jax.random.split(jax.random.fold_in(key, 1), config.batch_size)
        return learner.update(config, state, replay_buffer.sample(ring, bits), keys)

    return jax.lax.scan(step, state, jax.random.split(key, UPDATES))[0]


@pytest.fixture
def solve(config, state):
    """Trains on ``outcome(observation, action) -> reward, discount, next`` of random footsteps.

    Returns value(o) of the actor's action there, and action(o); o is the first observation.
    """

    def run(observations, outcome):
        rng = np.random.default_rng(0)
        o = rng.choice(observations, N).astype(np.float32)
        a = rng.uniform(-1, 1, N).astype(np.float32)
        reward, discount, following = (np.broadcast_to(np.float32(x), (N,)) for x in outcome(o, a))
        pad = functools.partial(np.pad, pad_width=((0, 0), (0, 1)))  # the second observation is idle
        data = Transition(pad(o[:, None]), a[:, None], reward, discount, pad(following[:, None]))
        trained = _train(config, state, jax.tree.map(jnp.asarray, data), jax.random.key(1))
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
