"""Exploration noise: known numbers."""

import math

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


def walked(config, seconds=0.02, count=400, walkers=500):
    """[walkers, count, 2] of noise, from nothing on."""

    def step(noises, key):
        keys = jax.random.split(key, walkers)
        noises = jax.vmap(lambda n, k: noise.on(config, seconds, n, k))(noises, keys)
        return noises, noises

    keys = jax.random.split(jax.random.key(0), count)
    told = jax.lax.scan(step, jnp.zeros((walkers, 2)), keys)[1]
    return np.swapaxes(np.asarray(told), 0, 1)


def test_noise_has_unit_variance_and_forgets_itself_in_its_time():
    settled = walked(DDPGConfig(noise_seconds=0.4))[:, 200:]
    assert settled.std() == pytest.approx(1.0, abs=0.02) and abs(settled.mean()) < 0.05
    for lag in (5, 20, 40):  # the process's correlation is exp(-t / T)
        both = settled[:, :-lag] * settled[:, lag:]
        assert both.mean() == pytest.approx(math.exp(-lag * 0.02 / 0.4), abs=0.05)
    assert abs(np.mean(settled[:, :, 0] * settled[:, :, 1])) < 0.05


def test_noise_without_memory_is_each_answers_own():
    told = walked(DDPGConfig(noise_seconds=0.0), count=50)
    assert told.std() == pytest.approx(1.0, abs=0.02)
    assert abs(np.mean(told[:, :-1] * told[:, 1:])) < 0.02
