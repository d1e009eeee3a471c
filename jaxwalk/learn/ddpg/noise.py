"""Exploration: Gaussian noise on the action that lasts for about a step, less of it as training goes on.

Walkers differ in how boldly they explore, as in Ape-X DPG (Horgan et al. 2018), so that the
replay holds both near-greedy and far-off footsteps at any time.
"""

from __future__ import annotations

import math

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


def on(config: DDPGConfig, seconds: float, noise: Float[Array, "A"], key: PRNGKeyArray) -> Float[Array, "A"]:
    """One walker's noise of unit variance, ``seconds`` later: an Ornstein-Uhlenbeck process, as in Lillicrap
    et al. 2015, that forgets itself in `noise_seconds`."""
    kept = math.exp(-seconds / config.noise_seconds) if config.noise_seconds else 0.0
    fresh = jax.random.normal(key, noise.shape, noise.dtype)
    return kept * noise + math.sqrt(1.0 - kept**2) * fresh
