"""The rings against plain Python lists."""

from dataclasses import replace
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.learn.ddpg import replay_buffer
from jaxwalk.task.transition import Transition

CAPACITY, WALKERS = 7, 3
add = jax.jit(replay_buffer.add)
sample = jax.jit(replay_buffer.sample, static_argnames="steps")


@pytest.fixture
def empty(transitions):
    return replay_buffer.init(WALKERS, CAPACITY, jax.tree.map(lambda x: x[0], transitions(1)))


def _held(replay, walker=0):
    """A walker's rewards, oldest first."""
    size, position = int(replay.size[walker]), int(replay.position[walker])
    start = position if size == CAPACITY else 0
    return [float(np.asarray(replay.rows.reward)[walker, (start + i) % CAPACITY]) for i in range(size)]


def _bits(count, blocks=1):
    return jax.random.bits(jax.random.key(0), (blocks, count), jnp.uint32)


def _filled(replay, transitions, times=1, only=None):
    """``replay`` after ``times`` rows of each walker, or ``only`` of some, and the rewards of these."""
    told = []
    for seed in range(times):
        rows = transitions(WALKERS, seed)
        replay = add(replay, rows, jnp.ones(WALKERS, bool) if only is None else jnp.asarray(only))
        told.append([float(x) for x in rows.reward])
    return replay, np.array(told)


@pytest.mark.parametrize("share", [0.0, 0.2, 0.5, 1.0])
def test_each_ring_is_its_walkers_list(empty, transitions, share):
    replay, expected = empty, [[] for _ in range(WALKERS)]
    for seed in range(20):
        rows = transitions(WALKERS, seed)
        mask = np.random.default_rng(seed).uniform(size=WALKERS) < share
        replay = add(replay, rows, jnp.asarray(mask))
        for walker in range(WALKERS):
            if mask[walker]:
                expected[walker] = [*expected[walker], float(rows.reward[walker])][-CAPACITY:]
            assert _held(replay, walker) == expected[walker]


def test_fields_stay_together_and_add_runs_inside_scan(empty, transitions):
    rows = jax.tree.map(lambda x: jnp.stack([x, x + 1]), transitions(WALKERS))
    mask = jnp.array([True, False, True])
    scanned, _ = jax.lax.scan(lambda r, batch: (replay_buffer.add(r, batch, mask), None), empty, rows)
    jax.tree.map(lambda r, x: np.testing.assert_array_equal(r[2, :2], x[:, 2]), scanned.rows, rows)
    assert scanned.size.tolist() == [2, 0, 2]


@pytest.mark.parametrize("bad", [jnp.nan, jnp.inf, -jnp.inf])
@pytest.mark.parametrize("name", ["observation", "action", "reward", "discount", "next_observation"])
def test_non_finite_rows_never_enter(empty, transitions, name, bad):
    rows = transitions(WALKERS)
    spoilt = replace(rows, **{name: getattr(rows, name).at[1].set(bad)})
    assert add(empty, spoilt, jnp.ones(WALKERS, bool)).size.tolist() == [1, 0, 1]


def test_each_block_gives_its_own_walkers_and_all_that_they_have(empty, transitions):
    replay, told = _filled(empty, transitions, times=4)
    batch = sample(replay, _bits(300, blocks=WALKERS))
    rewards = np.asarray(batch.reward).reshape(WALKERS, 300)
    for walker in range(WALKERS):
        values, counts = np.unique(rewards[walker], return_counts=True)
        np.testing.assert_array_equal(values, np.sort(told[:, walker]).astype(np.float32))
        assert counts.min() > 45  # 75 expected each
    together, counts = np.unique(np.asarray(sample(replay, _bits(900)).reward), return_counts=True)
    np.testing.assert_array_equal(together, np.unique(told).astype(np.float32))
    assert counts.min() > 45


def test_what_is_sampled_is_a_whole_row(empty, transitions):
    replay, _ = _filled(empty, transitions)
    rows = transitions(WALKERS)
    batch = sample(replay, _bits(5))
    row = int(jnp.argmax(rows.reward == batch.reward[0]))
    jax.tree.map(lambda x, y: np.testing.assert_array_equal(x[0], y[row]), batch, rows)


def test_empty_rings_sample_zeros(empty):
    assert all(not x.any() for x in jax.tree.leaves(sample(empty, _bits(3), steps=3)))


def test_no_room(transitions):
    with pytest.raises(ValueError, match="capacity 0"):
        replay_buffer.init(1, 0, transitions(1))


def _life(*rows):
    """One walker's replay of ``rows``: (place it was decided at, reward, discount, place that came of it)."""
    columns = [jnp.asarray(x, jnp.float32) for x in zip(*rows, strict=True)]
    seen, reward, discount, after = columns
    zero = jnp.zeros(())
    example = Transition(jnp.zeros(1), jnp.zeros(1), zero, zero, jnp.zeros(1))
    replay = replay_buffer.init(1, CAPACITY, example)
    for i in range(len(rows)):
        one = Transition(seen[i, None], jnp.zeros(1), reward[i], discount[i], after[i, None])
        replay = add(replay, jax.tree.map(lambda x: x[None], one), jnp.ones(1, bool))
    return replay


def _returns(replay, steps):
    """(reward, discount, place that came of it) by the place where each sampled transition began."""
    batch = jax.device_get(partial(sample, steps=steps)(replay, _bits(200)))
    numbers = batch.observation[:, 0], batch.reward, batch.discount, batch.next_observation[:, 0]
    return {float(o): (float(r), float(d), float(n)) for o, r, d, n in zip(*numbers, strict=True)}


def test_a_return_holds_the_rewards_of_the_decisions_that_followed():
    found = _returns(_life((0, 1, 0.5, 1), (1, 10, 0.5, 2), (2, 100, 0.5, 3), (3, 1000, 0.5, 4)), steps=3)
    assert found == {
        0.0: (1 + 5 + 25, 0.125, 3.0),
        1.0: (10 + 50 + 250, 0.125, 4.0),
        2.0: (100 + 500, 0.25, 4.0),  # no more is remembered
        3.0: (1000, 0.5, 4.0),
    }


def test_a_return_ends_at_a_fall_and_at_an_episodes_end():
    fell = _returns(_life((0, 1, 0.5, 1), (1, -10, 0.0, 9), (9, 100, 0.5, 3)), steps=3)
    assert fell[0.0] == (1 - 5, 0.0, 9.0) and fell[1.0] == (-10, 0.0, 9.0)
    ended = _returns(_life((0, 1, 0.5, 1), (7, 10, 0.5, 8)), steps=3)
    assert ended[0.0] == (1, 0.5, 1.0)


def test_a_return_does_not_go_around_the_ring():
    rows = [(i, 1, 0.5, i + 1) for i in range(CAPACITY + 2)]
    rows[-1] = (CAPACITY + 1, 1, 0.5, 2)  # it ends where the oldest that is left began
    assert _returns(_life(*rows), steps=2)[float(CAPACITY + 1)] == (1, 0.5, 2.0)
