"""Running mean and variance of observations (Chan, Golub & LeVeque 1979), merged batch by batch.

Replay holds raw observations; they are normalised when sampled, so that old ones too are
seen through today's statistics.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Bool, Float

from jaxwalk.task.transition import Leaf

CLIP = 10.0  # largest normalised observation, in standard deviations
_MIN_VARIANCE = 1e-8  # below it an observation counts as constant and is only centred


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Normalizer:
    """Statistics of all rows seen.

    Attributes:
      count: [], rows seen.
      mean: [O], in the units of each observable.
      m2: [O], sum of squared deviations from the mean, units squared.
      enabled: static; False makes ``update`` and ``normalize`` identities.
    """

    count: Leaf
    mean: Leaf
    m2: Leaf
    enabled: bool = field(default=True, metadata={"static": True})

    @property
    def std(self) -> Float[Array, " O"]:
        """Standard deviation [O]; 1 where the observation has not varied."""
        variance = self.m2 / jnp.maximum(self.count, 1.0)
        return jnp.sqrt(jnp.where(variance > _MIN_VARIANCE, variance, 1.0))

    @property
    def clip(self) -> float | None:
        """Largest normalised observation; None: no limit."""
        return CLIP if self.enabled else None


def init(observation_size: int, enabled: bool = True) -> Normalizer:
    """Statistics of no rows; they normalise to the observation itself."""
    mean, m2 = jnp.zeros((observation_size,)), jnp.zeros((observation_size,))
    return Normalizer(count=jnp.zeros(()), mean=mean, m2=m2, enabled=enabled)


def update(
    state: Normalizer, batch: Float[Array, "B O"], mask: Bool[Array, " B"], axis_name: str | None = None
) -> Normalizer:
    """Merge the rows of ``batch`` [B, O] that ``mask`` [B] admits and that are finite.

    With ``axis_name``, the batches of all members of that mapped axis are merged at once, and
    every member that held equal statistics ends with equal ones.
    """
    if not state.enabled:
        return state

    def total(x: Array) -> Array:
        x = jnp.sum(x, axis=0)
        return x if axis_name is None else lax.psum(x, axis_name)

    rows = (mask & jnp.all(jnp.isfinite(batch), axis=-1))[:, None]
    added = total(rows.astype(batch.dtype))[0]
    mean = total(jnp.where(rows, batch, 0.0)) / jnp.maximum(added, 1.0)
    m2 = total(jnp.where(rows, jnp.square(batch - mean[None]), 0.0))

    count = state.count + added
    share = added / jnp.maximum(count, 1.0)
    delta = mean - state.mean
    return Normalizer(
        count=count,
        mean=state.mean + share * delta,
        m2=state.m2 + m2 + state.count * share * jnp.square(delta),
        enabled=True,
    )


def normalize(state: Normalizer, observation: Float[Array, "*B O"]) -> Float[Array, "*B O"]:
    """Observations, or the first numbers of them, in standard deviations from the mean, within +-``CLIP``."""
    size = observation.shape[-1]
    return standardize(observation, state.mean[:size], state.std[:size], state.clip)


def standardize(
    observation: Float[Array, "*B O"], mean: Float[Array, " O"], std: Float[Array, " O"], clip: float | None
) -> Float[Array, "*B O"]:
    """``(observation - mean) / std``, within +-``clip`` unless that is None."""
    mean = jnp.broadcast_to(mean, observation.shape)
    std = jnp.broadcast_to(std, observation.shape)
    scaled = (observation - mean) / std
    return scaled if clip is None else jnp.clip(scaled, -clip, clip)
