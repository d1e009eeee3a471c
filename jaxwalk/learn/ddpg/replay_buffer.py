"""Replay: a ring of transitions for each walker, on the devices, written inside ``lax.scan``.

Walkers and batch are split into as many equal blocks, so that what is drawn does not depend on how many
devices these lie on. A ring is one walker's life in order: what followed a transition lies in the next slot,
so that returns over several decisions are put together as they are drawn.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Bool, Int, UInt32

from jaxwalk.common.parallel.devices import anywhere
from jaxwalk.task.transition import Leaf, Transition

_Way = tuple[Transition, Array, Array]  # so far; the slot that it has come to; whether it goes on


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Replay:
    """The last C transitions of each of W walkers, C being a ring's capacity.

    Attributes:
      rows: transitions, every field with leading axes [W, C]; only the first ``size`` are filled.
      position: [W], slot that is written next.
      size: [W], slots filled.
    """

    rows: Transition
    position: Leaf
    size: Leaf

    @property
    def capacity(self) -> int:
        """C, transitions that one ring has room for."""
        return self.rows.reward.shape[1]


def init(walkers: int, capacity: int, example: Transition) -> Replay:
    """Empty rings with room for ``capacity`` transitions each, shaped like the unbatched ``example``.

    Raises:
      ValueError: a capacity below 1.
    """
    if capacity < 1:
        raise ValueError(f"replay capacity {capacity}: at least 1 transition must fit")
    rows = jax.tree.map(lambda x: jnp.zeros((walkers, capacity, *jnp.shape(x)), jnp.result_type(x)), example)
    return Replay(rows, position=jnp.zeros(walkers, jnp.int32), size=jnp.zeros(walkers, jnp.int32))


def add(replay: Replay, transitions: Transition, mask: Bool[Array, " W"]) -> Replay:
    """Append to each walker's ring its one of W transitions, if ``mask`` [W] admits it and it is finite.

    The oldest makes room. Costs O(W), not O(C), where the caller gives the rings up (a scan's carry, a
    donated argument), and next to nothing when no row is admitted.
    """
    for leaf in jax.tree.leaves(transitions):
        mask = mask & jnp.all(jnp.isfinite(leaf), axis=tuple(range(1, leaf.ndim)))
    return lax.cond(anywhere(jnp.any(mask)), _write, lambda rings, *_: rings, replay, transitions, mask)


def _write(replay: Replay, transitions: Transition, mask: Bool[Array, " W"]) -> Replay:
    walkers, capacity = replay.size.shape[0], replay.capacity
    row = jnp.where(mask, _row(jnp.arange(walkers), replay.position, capacity), walkers * capacity)

    def written(rows: Array, new: Array) -> Array:
        flat = rows.reshape(-1, *rows.shape[2:])
        return flat.at[row].set(new, mode="drop").reshape(rows.shape)

    one = mask.astype(jnp.int32)
    return Replay(
        rows=jax.tree.map(written, replay.rows, transitions),
        position=(replay.position + one) % capacity,
        size=jnp.minimum(replay.size + one, capacity),
    )


def sample(replay: Replay, bits: UInt32[Array, "R S"], steps: int = 1) -> Transition:
    """S transitions of each of R blocks of walkers, with replacement: [R x S], block by block.

    An empty ring gives rows of zeros; callers wait until something is in each.

    Args:
      bits: random ones, which choose a walker of the block and one of its transitions.
      steps: decisions over which a transition reaches at most (n-step return: Sutton and Barto 2018, ch. 7):
        its reward is what they earned, discounted, up to a fall, the end of an episode or of the ring, and
        its discount and next observation are those of the last. What was done after the first is taken as
        it was, explored or by an older actor.
    """
    blocks = bits.shape[0]
    each = replay.size.shape[0] // blocks
    which, chosen = bits % jnp.uint32(each), bits // jnp.uint32(each)
    ring = (which.astype(jnp.int32) + each * jnp.arange(blocks, dtype=jnp.int32)[:, None]).reshape(-1)
    size = jnp.maximum(replay.size[ring], 1).astype(jnp.uint32)
    return followed(replay, ring, (chosen.reshape(-1) % size).astype(jnp.int32), steps)


def followed(replay: Replay, ring: Int[Array, " N"], slot: Int[Array, " N"], steps: int) -> Transition:
    """[N] the transitions in slots of rings, each reaching over at most so many ``steps``: see `sample`."""
    capacity, written = replay.capacity, replay.position[ring]

    def at(slot: Int[Array, " N"]) -> Transition:
        row = _row(ring, slot, capacity)
        return jax.tree.map(lambda rows: rows.reshape(-1, *rows.shape[2:])[row], replay.rows)

    def further(carry: _Way, _: None) -> tuple[_Way, None]:
        so_far, slot, goes_on = carry
        slot = (slot + 1) % capacity
        row = at(slot)
        # A row goes on where the one before it ended, or it is of another episode.
        follows = jnp.all(row.observation == so_far.next_observation, axis=-1) & (slot != written)
        goes_on = goes_on & follows & (so_far.discount > 0)
        longer = replace(
            so_far,
            reward=so_far.reward + so_far.discount * row.reward,
            discount=so_far.discount * row.discount,
            next_observation=row.next_observation,
        )
        taken = jax.tree.map(
            lambda new, old: jnp.where(goes_on.reshape(-1, *(1,) * (new.ndim - 1)), new, old), longer, so_far
        )
        return (taken, slot, goes_on), None

    first = at(slot)
    return lax.scan(further, (first, slot, jnp.ones(slot.shape, bool)), length=steps - 1)[0][0]


def _row(ring: Int[Array, " N"], slot: Int[Array, " N"], capacity: int) -> Int[Array, " N"]:
    """Slots of rings as rows of all of them."""
    return slot + capacity * ring
