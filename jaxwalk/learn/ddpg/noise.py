"""Exploration: Gaussian noise on the action, less of it as training goes on.

Walkers differ in how boldly they explore, as in Ape-X DPG (Horgan et al. 2018), so that the
replay holds both near-greedy and far-off footsteps at any time.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from jaxwalk.config import DDPGConfig


def spread(walkers: int, ratio: float) -> Float[Array, " N"]:
    """Each walker's share of the exploration noise [N]: log-spaced, geometric mean 1.

    The last walker's is ``ratio`` times the first's. A single walker has 1.
    """
    if walkers == 1:
        return jnp.ones((1,))
    return ratio ** jnp.linspace(-0.5, 0.5, walkers)


def scale(config: DDPGConfig, progress: Float[Array, ""], walkers: int) -> Float[Array, " N"]:
    """Standard deviation of each walker's noise [N], in units of half the action range.

    Linear in ``progress`` (0 at the start of training, 1 at its end and after) from
    ``noise_start`` to ``noise_end``.
    """
    progress = jnp.clip(progress, 0.0, 1.0)
    level = config.noise_start + progress * (config.noise_end - config.noise_start)
    return level * spread(walkers, config.noise_spread)


def perturb(action: Float[Array, "A"], key: PRNGKeyArray, scale: Float[Array, ""]) -> Float[Array, "A"]:
    """One walker's ``action`` plus Gaussian noise of standard deviation ``scale``, clipped to [-1, 1]."""
    noise = scale * jax.random.normal(key, action.shape, action.dtype)
    return jnp.clip(action + noise, -1.0, 1.0)
