"""The rings against plain Python lists."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.learn.ddpg import replay_buffer

CAPACITY, BATCH = 7, 10
add = jax.jit(replay_buffer.add)
sample = jax.jit(replay_buffer.sample)


@pytest.fixture
def empty(transitions):
    return replay_buffer.init(1, CAPACITY, jax.tree.map(lambda x: x[0], transitions(1)))


def _held(rings, which=0):
    """A ring's rewards, oldest first."""
    size, position = int(rings.size[which]), int(rings.position[which])
    start = position if size == CAPACITY else 0
    return [float(np.asarray(rings.rows.reward)[which, (start + i) % CAPACITY]) for i in range(size)]


def _bits(count, rings=1):
    return jax.random.bits(jax.random.key(0), (rings, count), jnp.uint32)


@pytest.mark.parametrize("share", [0.0, 0.2, 0.5, 1.0])
def test_ring_equals_a_list(empty, transitions, share):
    ring, expected = empty, []
    for seed in range(8):
        rows = transitions(BATCH, seed)
        mask = np.random.default_rng(seed).uniform(size=BATCH) < share  # 1.0: more rows than room
        ring = add(ring, rows, jnp.asarray(mask))
        expected = (expected + [float(r) for r in rows.reward[mask]])[-CAPACITY:]
        assert _held(ring) == expected


def test_each_ring_keeps_its_own_rows(transitions):
    rings = replay_buffer.init(2, CAPACITY, jax.tree.map(lambda x: x[0], transitions(1)))
    expected = [[], []]
    for seed in range(8):
        rows = transitions(2 * BATCH, seed)
        mask = np.random.default_rng(seed).uniform(size=2 * BATCH) < np.repeat([0.1, 0.9], BATCH)
        rings = add(rings, rows, jnp.asarray(mask))
        for which, part in enumerate((slice(BATCH), slice(BATCH, None))):
            new = [float(r) for r in rows.reward[part][mask[part]]]
            expected[which] = (expected[which] + new)[-CAPACITY:]
            assert _held(rings, which) == expected[which]
    batch = np.asarray(sample(rings, _bits(50, 2)).reward)
    assert set(batch[:50]) == set(np.array(expected[0], np.float32))
    assert set(batch[50:]) == set(np.array(expected[1], np.float32))


def test_fields_stay_together_and_add_runs_inside_scan(empty, transitions):
    rows = jax.tree.map(lambda x: jnp.stack([x, x + 1]), transitions(3))
    mask = jnp.array([True, False, True])
    scanned, _ = jax.lax.scan(lambda ring, batch: (replay_buffer.add(ring, batch, mask), None), empty, rows)
    expected = jax.tree.map(lambda x: x[:, jnp.array([0, 2])].reshape(4, *x.shape[2:]), rows)
    jax.tree.map(lambda ring, x: np.testing.assert_array_equal(ring[0, :4], x), scanned.rows, expected)
    assert int(scanned.size[0]) == 4


@pytest.mark.parametrize("bad", [jnp.nan, jnp.inf, -jnp.inf])
@pytest.mark.parametrize("name", ["observation", "action", "reward", "discount", "next_observation"])
def test_non_finite_rows_never_enter(empty, transitions, name, bad):
    rows = transitions(BATCH)
    spoilt = replace(rows, **{name: getattr(rows, name).at[4].set(bad)})
    ring = add(empty, spoilt, jnp.arange(BATCH) >= 3)
    assert _held(ring) == [float(rows.reward[i]) for i in (3, 5, 6, 7, 8, 9)]


def test_samples_only_what_was_added_and_all_of_it(empty, transitions):
    rows = transitions(BATCH)
    ring = add(empty, rows, jnp.arange(BATCH) < 4)
    batch = sample(ring, _bits(400))
    values, counts = np.unique(np.asarray(batch.reward), return_counts=True)
    np.testing.assert_array_equal(values, np.sort(rows.reward[:4]))
    assert counts.min() > 60  # 100 expected each
    row = int(jnp.argmax(rows.reward == batch.reward[0]))
    jax.tree.map(lambda x, y: np.testing.assert_array_equal(x[0], y[row]), batch, rows)


def test_empty_ring_samples_zeros(empty):
    assert all(not x.any() for x in jax.tree.leaves(sample(empty, _bits(3))))


def test_no_room(transitions):
    with pytest.raises(ValueError, match="capacity 0"):
        replay_buffer.init(1, 0, transitions(1))
