"""Replay: a ring of transitions that lives on the device and is written inside ``lax.scan``."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Bool, PRNGKeyArray

from jaxwalk.ddpg.types import Leaf, Transition
from jaxwalk.devices import anywhere


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Replay:
    """The ring of the last C transitions, C being its capacity.

    Attributes:
      rows: transitions, every field with a leading axis C; only the first ``size`` are filled.
      position: [], slot that is written next.
      size: [], slots filled.
    """

    rows: Transition
    position: Leaf
    size: Leaf

    @property
    def capacity(self) -> int:
        return self.rows.reward.shape[0]


def init(capacity: int, example: Transition) -> Replay:
    """An empty ring with room for ``capacity`` transitions shaped like the unbatched ``example``.

    Raises:
      ValueError: a capacity below 1.
    """
    if capacity < 1:
        raise ValueError(f"replay capacity {capacity}: at least 1 transition must fit")
    rows = jax.tree.map(lambda x: jnp.zeros((capacity, *jnp.shape(x)), jnp.result_type(x)), example)
    return Replay(rows, position=jnp.int32(0), size=jnp.int32(0))


def add(replay: Replay, transitions: Transition, mask: Bool[Array, " N"]) -> Replay:
    """Append, in order, those of N transitions that ``mask`` [N] admits and that are finite.

    The oldest make room; of more than C at once, the last C stay. Costs O(N), not O(C), where
    the caller gives the ring up (a scan's carry, a donated argument), and next to nothing when
    no row is admitted, which is most windows of a simulation.
    """
    for leaf in jax.tree.leaves(transitions):
        mask = mask & jnp.all(jnp.isfinite(leaf), axis=tuple(range(1, leaf.ndim)))
    return lax.cond(anywhere(jnp.any(mask)), _write, lambda ring, *_: ring, replay, transitions, mask)


def _write(replay: Replay, transitions: Transition, mask: Bool[Array, " N"]) -> Replay:
    rank = jnp.cumsum(mask, dtype=jnp.int32) - 1  # of each admitted row among the admitted
    total = rank[-1] + 1
    kept = mask & (rank >= total - replay.capacity)
    slot = jnp.where(kept, (replay.position + rank) % replay.capacity, replay.capacity)
    return Replay(
        rows=jax.tree.map(lambda ring, new: ring.at[slot].set(new, mode="drop"), replay.rows, transitions),
        position=(replay.position + total) % replay.capacity,
        size=jnp.minimum(replay.size + total, replay.capacity),
    )


def sample(replay: Replay, key: PRNGKeyArray, batch_size: int) -> Transition:
    """``batch_size`` transitions, uniformly with replacement.

    An empty ring gives rows of zeros; callers wait until something is in it.
    """
    slots = jax.random.randint(key, (batch_size,), 0, jnp.maximum(replay.size, 1))
    return jax.tree.map(lambda ring: ring[slots], replay.rows)
