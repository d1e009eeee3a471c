"""Running statistics against numpy on everything seen at once."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.learn.ddpg import normalizer

update = jax.jit(normalizer.update)


def _batches(n=5, rows=64):
    rng = np.random.default_rng(0)
    scale, offset = np.array([1.0, 0.01, 30.0]), np.array([5.0, -1.0, 0.0])
    x = (rng.normal(size=(n, rows, 3)) * scale + offset).astype(np.float32)
    return x, rng.uniform(size=(n, rows)) < 0.6


def test_equals_numpy_on_all_admitted_rows():
    x, mask = _batches()
    mask[2] = False  # an empty batch changes nothing
    x[0, 0], mask[0, 0] = np.nan, True
    x[1, 1, 2], mask[1, 1] = np.inf, True
    state = normalizer.init(3)
    for batch, admitted in zip(x, mask, strict=True):
        state = update(state, jnp.asarray(batch), jnp.asarray(admitted))
    seen = x[mask & np.isfinite(x).all(-1)].astype(np.float64)
    assert int(state.count) == len(seen)
    np.testing.assert_allclose(state.mean, seen.mean(0), rtol=1e-5, atol=1e-4)
    np.testing.assert_allclose(state.std, seen.std(0), rtol=1e-4)
    expected = (x[3] - seen.mean(0)) / seen.std(0)
    np.testing.assert_allclose(normalizer.normalize(state, jnp.asarray(x[3])), expected, rtol=1e-2, atol=1e-3)


def test_parts_of_a_mapped_axis_equal_the_whole():
    x, mask = _batches(n=4)
    start = update(normalizer.init(3), jnp.asarray(x[0]) + 1.0, jnp.asarray(mask[0]))
    part = jax.vmap(lambda b, m: normalizer.update(start, b, m, axis_name="part"), axis_name="part")
    parts = jax.jit(part)(jnp.asarray(x), jnp.asarray(mask))
    whole = update(start, jnp.asarray(x.reshape(-1, 3)), jnp.asarray(mask.reshape(-1)))
    for i in range(4):
        one = jax.tree.map(lambda x, i=i: np.asarray(x)[i], parts)
        jax.tree.map(lambda p, w: np.testing.assert_allclose(p, w, rtol=1e-5, atol=1e-5), one, whole)


def test_constant_observation_is_only_centred():
    state = update(normalizer.init(1), jnp.full((9, 1), 1.8), jnp.ones((9,), bool))
    np.testing.assert_allclose(normalizer.normalize(state, jnp.array([1.8])), [0.0], atol=1e-6)
    np.testing.assert_allclose(normalizer.normalize(state, jnp.array([2.0])), [0.2], atol=1e-5)


def test_normalised_observations_are_bounded():
    state = update(normalizer.init(1), jnp.array([[-1.0], [1.0]]), jnp.ones((2,), bool))
    far = normalizer.normalize(state, jnp.array([[1e6], [-1e6]]))
    np.testing.assert_array_equal(far, [[normalizer.CLIP], [-normalizer.CLIP]])


@pytest.mark.parametrize("shape", [(2,), (4, 2), (3, 4, 2)])
def test_disabled_is_the_identity(shape):
    state = update(normalizer.init(2, enabled=False), jnp.full((4, 2), 9.0), jnp.ones((4,), bool))
    x = 100.0 * jnp.ones(shape)
    np.testing.assert_array_equal(normalizer.normalize(state, x), x)
