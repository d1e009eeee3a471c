"""Exploration noise: known numbers."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.config import DDPGConfig
from jaxwalk.learn.ddpg import noise


def test_spread_is_logarithmic_with_geometric_mean_one():
    np.testing.assert_allclose(noise.spread(3, 4.0), [0.5, 1.0, 2.0], rtol=1e-6)
    np.testing.assert_allclose(noise.spread(5, 1.0), 1.0)
    np.testing.assert_allclose(noise.spread(1, 4.0), [1.0])


@pytest.mark.parametrize(("progress", "level"), [(0.0, 0.4), (0.5, 0.225), (1.0, 0.05), (1.5, 0.05)])
def test_scale_decays_linearly_and_then_stays(progress, level):
    config = DDPGConfig(noise_start=0.4, noise_end=0.05, noise_spread=4.0)
    scale = noise.scale(config, jnp.float32(progress), 3)
    np.testing.assert_allclose(scale, [level / 2, level, level * 2], rtol=1e-5)


def test_perturb_has_each_walkers_spread_and_stays_in_range():
    scale = jnp.array([0.0, 0.05, 0.2, 5.0])
    action = jnp.full((4, 20_000), 0.1)
    moved = jax.vmap(noise.perturb)(action, jax.random.split(jax.random.key(0), 4), scale)
    np.testing.assert_allclose(moved[:3].std(axis=1), scale[:3], rtol=0.03, atol=1e-7)
    np.testing.assert_allclose(moved[:3].mean(axis=1), 0.1, atol=0.01)
    assert moved.min() == -1.0 and moved.max() == 1.0
