"""Replay: rings of transitions that live on the devices and are written inside ``lax.scan``.

Each ring belongs to a block of walkers, and each gives an equal share of a batch: so it does not matter
on how many devices the rings lie.
"""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Bool, UInt32

from jaxwalk.common.parallel.devices import anywhere
from jaxwalk.task.transition import Leaf, Transition


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Replay:
    """R rings, each of the last C transitions of its walkers, C being its capacity.

    Attributes:
      rows: transitions, every field with leading axes [R, C]; only the first ``size`` are filled.
      position: [R], slot that is written next.
      size: [R], slots filled.
    """

    rows: Transition
    position: Leaf
    size: Leaf

    @property
    def capacity(self) -> int:
        """C, transitions that one ring has room for."""
        return self.rows.reward.shape[1]


def init(rings: int, capacity: int, example: Transition) -> Replay:
    """Empty rings with room for ``capacity`` transitions each, shaped like the unbatched ``example``.

    Raises:
      ValueError: a capacity below 1.
    """
    if capacity < 1:
        raise ValueError(f"replay capacity {capacity}: at least 1 transition must fit")
    rows = jax.tree.map(lambda x: jnp.zeros((rings, capacity, *jnp.shape(x)), jnp.result_type(x)), example)
    return Replay(rows, position=jnp.zeros(rings, jnp.int32), size=jnp.zeros(rings, jnp.int32))


def add(replay: Replay, transitions: Transition, mask: Bool[Array, " N"]) -> Replay:
    """Append, in order, those of N transitions that ``mask`` [N] admits and that are finite.

    The first N / R go to the first ring, and so on. The oldest make room; of more than C at once, the last
    C stay. Costs O(N), not O(C), where the caller gives the rings up (a scan's carry, a donated argument),
    and next to nothing when no row is admitted.
    """
    for leaf in jax.tree.leaves(transitions):
        mask = mask & jnp.all(jnp.isfinite(leaf), axis=tuple(range(1, leaf.ndim)))
    return lax.cond(anywhere(jnp.any(mask)), _write, lambda rings, *_: rings, replay, transitions, mask)


def _write(replay: Replay, transitions: Transition, mask: Bool[Array, " N"]) -> Replay:
    rings, capacity = replay.size.shape[0], replay.capacity
    mask = mask.reshape(rings, -1)
    rank = jnp.cumsum(mask, axis=1, dtype=jnp.int32) - 1  # of each admitted row among its ring's
    total = rank[:, -1] + 1
    kept = mask & (rank >= total[:, None] - capacity)
    slot = _flat((replay.position[:, None] + rank) % capacity, capacity)
    slot = jnp.where(kept, slot, rings * capacity).reshape(-1)

    def written(rows: Array, new: Array) -> Array:
        flat = rows.reshape(-1, *rows.shape[2:])
        return flat.at[slot].set(new, mode="drop").reshape(rows.shape)

    return Replay(
        rows=jax.tree.map(written, replay.rows, transitions),
        position=(replay.position + total) % capacity,
        size=jnp.minimum(replay.size + total, capacity),
    )


def sample(replay: Replay, bits: UInt32[Array, "R S"]) -> Transition:
    """S transitions of each ring, with replacement: [R x S], ring by ring. Random ``bits`` choose uniformly.

    An empty ring gives rows of zeros; callers wait until something is in it.
    """
    slots = bits % jnp.maximum(replay.size, 1).astype(jnp.uint32)[:, None]
    index = _flat(slots.astype(jnp.int32), replay.capacity).reshape(-1)
    return jax.tree.map(lambda rows: rows.reshape(-1, *rows.shape[2:])[index], replay.rows)


def _flat(slots: Array, capacity: int) -> Array:
    """Slots [R, N] of each ring as rows of all of them."""
    return slots + capacity * jnp.arange(slots.shape[0], dtype=jnp.int32)[:, None]
