"""One update of the learner: its arithmetic, its switches, and what it does with bad numbers."""

import os
import subprocess
import sys
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.config import DDPGConfig
from jaxwalk.config.presets import PRESETS
from jaxwalk.learn.ddpg import learner, networks

_init = jax.jit(learner.init, static_argnums=(0, 2, 3))


def _close(a, b, **tolerance):
    jax.tree.map(lambda x, y: np.testing.assert_allclose(np.asarray(x), np.asarray(y), **tolerance), a, b)


def _same(a, b):
    return all(jax.tree.leaves(jax.tree.map(lambda x, y: np.array_equal(np.asarray(x), np.asarray(y)), a, b)))


def test_actor_starts_at_the_initial_action():
    initial = (0.4, -0.8)
    state = _init(DDPGConfig(), jax.random.key(3), 4, initial)
    action = learner.act(DDPGConfig(), state, jax.random.normal(jax.random.key(4), (100, 4)))
    np.testing.assert_allclose(action, np.broadcast_to(initial, (100, 2)), atol=0.02)


def test_what_is_privileged_moves_the_critic_and_no_answer():
    config = DDPGConfig(hidden=(8,))
    state = learner.init(config, jax.random.key(3), 4, (0.4, -0.8), privileged=2)
    assert state.actor["hidden_0"]["kernel"].shape == (4, 8)
    seen = jax.random.normal(jax.random.key(4), (5, 6))
    other = seen.at[:, 4:].add(1.0)
    answers = [learner.act(config, state, x) for x in (seen, other, seen[:, :4])]
    np.testing.assert_array_equal(answers[0], answers[1])
    np.testing.assert_array_equal(answers[0], answers[2])
    values = [learner.value(config, state, x, answers[0]) for x in (seen, other)]
    assert (np.asarray(values[0]) != np.asarray(values[1])).all()


def test_random_start_is_drawn_by_the_seed_from_the_whole_range():
    config = DDPGConfig(hidden=(8,), start="random")
    observation = jax.random.normal(jax.random.key(4), (5, 4))
    draw = jax.jit(
        jax.vmap(lambda key: learner.act(config, learner.init(config, key, 4, (0.4, -0.8)), observation))
    )
    first = np.asarray(draw(jax.random.split(jax.random.key(0), 64)))
    np.testing.assert_allclose(
        first, np.broadcast_to(first[:, :1], first.shape), atol=0.02
    )  # everywhere alike
    starts = first[:, 0]
    assert (starts.min(0) < -0.8).all() and (starts.max(0) > 0.8).all() and (np.abs(starts) < 0.97).all()
    assert (np.abs(starts.mean(0)) < 0.25).all()


def test_initial_action_out_of_reach():
    with pytest.raises(ValueError, match="tanh"):
        networks.init_actor((8,), jax.random.key(0), 2, (1.0,))


def test_paper_layers():
    paper = PRESETS["paper"].ddpg
    state = jax.eval_shape(lambda key: learner.init(paper, key, 4, (0.0, 0.0)), jax.random.key(0))
    shapes = jax.tree.map(jnp.shape, {"actor": state.actor, "critic": state.critic})
    assert shapes["actor"]["hidden_0"]["kernel"] == (4, 400)
    assert shapes["actor"]["hidden_1"]["kernel"] == (400, 300)
    assert shapes["critic"]["hidden_0"]["kernel"] == (1, 6, 400)
    assert shapes["critic"]["output"]["kernel"] == (1, 300, 1)


def test_twin_critics_start_apart():
    critic = networks.critics((8,), True, 2)
    params = jax.jit(critic.init)(jax.random.key(0), jnp.zeros(2), jnp.zeros(1))["params"]
    assert not jnp.array_equal(*params["hidden_0"]["kernel"])
    values = networks.applied(critic, params, jnp.ones((5, 2)), jnp.ones((5, 1)))
    assert values.shape == (2, 5)


def test_targets_follow_by_tau(config, state, update, transitions):
    ones = replace(
        state,
        target_actor=jax.tree.map(jnp.ones_like, state.actor),
        target_critic=jax.tree.map(jnp.ones_like, state.critic),
        updates=jnp.int32(1),  # TD3's actor is due at the second update
    )
    new, _ = update(config, ones, transitions(config.batch_size))
    for online, target in ((new.actor, new.target_actor), (new.critic, new.target_critic)):
        _close(target, jax.tree.map(lambda x: 0.95 + 0.05 * np.asarray(x), online), rtol=1e-6, atol=1e-6)


def test_target_is_reward_plus_discounted_smaller_value(config, state, update, transitions):
    zero = jax.tree.map(jnp.zeros_like, state.target_critic)
    members = 2 if config.twin else 1
    zero["output"]["bias"] = jnp.array([[5.0], [3.0]])[:members]
    batch = replace(transitions(config.batch_size), reward=jnp.full((config.batch_size,), 0.5, jnp.float32))
    _, metrics = update(config, replace(state, target_critic=zero), batch)
    assert metrics.target_mean == pytest.approx(0.5 + 0.9 * (3.0 if config.twin else 5.0), rel=1e-5)


def test_only_td3_smooths_the_target_and_delays_the_actor(config, state, update, transitions):
    batch = transitions(config.batch_size)
    first, metrics = update(config, state, batch, jax.random.key(1))
    _, others = update(config, state, batch, jax.random.key(2))
    assert (metrics.target_mean != others.target_mean) == config.twin
    assert _same(first.actor, state.actor) == config.twin
    assert _same(first.target_critic, state.target_critic) == config.twin
    second, _ = update(config, first, batch)
    assert not _same(second.actor, first.actor)
    assert not _same(second.target_critic, first.target_critic)
    assert int(second.updates) == 2


@pytest.mark.parametrize("name", ["observation", "action", "reward", "discount", "next_observation"])
def test_a_nan_in_the_batch_skips_the_update(config, state, update, transitions, name):
    batch = transitions(config.batch_size)
    bad = replace(batch, **{name: getattr(batch, name).at[3].set(jnp.nan)})
    new, metrics = update(config, state, bad)
    assert int(metrics.skipped) == 1
    assert _same(new, replace(state, metrics=replace(state.metrics, skipped=jnp.int32(1))))
    after, metrics = update(config, new, batch)
    assert int(metrics.skipped) == 1 and int(after.updates) == 1
    assert all(np.isfinite(x) for x in jax.tree.leaves(metrics))


def test_one_trace_for_many_updates(config, state, update, transitions):
    update(config, state, transitions(config.batch_size))
    before = update.traces
    for i in range(5):
        state, _ = update(config, state, transitions(config.batch_size, seed=i), jax.random.key(i))
    assert update.traces == before


_ON_TWO_DEVICES = """
import functools, jax, numpy as np
from jax.sharding import Mesh, PartitionSpec as P
from jaxwalk.common import runtime
from jaxwalk.config import DDPGConfig
from jaxwalk.learn.ddpg import learner
from jaxwalk.task.transition import Transition

runtime.setup()  # programs are remembered
keys = jax.random.split(jax.random.key(0), 5)
shapes = (32, 2), (32, 1), (32,), (32,), (32, 2)
batch = Transition(*(jax.random.normal(k, s) for k, s in zip(keys, shapes)))
mesh = Mesh(jax.devices(), ("devices",))
config = DDPGConfig(hidden=(4,), max_grad_norm=0.0, twin=True, policy_delay=1,
                    critic_head_start=0)
state = jax.jit(learner.init, static_argnums=(0, 2, 3))(config, keys[0], 2, (0.25,))
update = functools.partial(learner.update, config)
smooth = jax.random.split(keys[1], 32)
whole, _ = jax.jit(update)(state, batch, smooth)
specs = dict(in_specs=(P(), P("devices"), P("devices")), out_specs=P())
for tracked in (True, False):  # whether JAX knows what is equal on all devices
    split = jax.shard_map(
        functools.partial(update, axis_name="devices"), mesh=mesh, check_vma=tracked, **specs
    )
    parts, _ = jax.jit(split)(state, batch, smooth)
    # Adam's moments are the gradient; its step would blow up rounding where that is nearly 0.
    for field in ("actor_optimizer", "critic_optimizer", "metrics"):
        close = functools.partial(np.testing.assert_allclose, rtol=1e-3, atol=1e-6)
        jax.tree.map(close, getattr(parts, field), getattr(whole, field))
"""


def test_two_devices_make_the_whole_step():
    """In a process of its own: the number of devices is fixed when it starts."""
    two = os.environ | {"JAX_NUM_CPU_DEVICES": "2"}
    done = subprocess.run([sys.executable, "-c", _ON_TWO_DEVICES], capture_output=True, text=True, env=two)
    assert done.returncode == 0, done.stderr[-2000:]


def test_weight_decay_shrinks_only_the_critics_kernels(transitions):
    config = DDPGConfig(hidden=(8,), critic_lr=0.1, weight_decay=0.5)
    optimizer = learner._optimizer(config, config.critic_lr, config.weight_decay)
    params = {"hidden_0": {"kernel": jnp.ones((1, 2, 2)), "bias": jnp.ones((1, 2))}}
    with jax.numpy_dtype_promotion("standard"):
        step, _ = optimizer.update(jax.tree.map(jnp.zeros_like, params), optimizer.init(params), params)
    bias, kernel = jax.tree.leaves(step)
    np.testing.assert_allclose(kernel, -0.05, rtol=1e-6)
    np.testing.assert_array_equal(bias, 0.0)
