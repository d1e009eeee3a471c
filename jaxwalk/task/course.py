"""Which pushes training deals: those whose outcome is open more often than those that all survive, or none.

Pushes are told apart by cells: the situation in which they come, side, size, and phase of the step at which
they begin. What comes of each is counted, and of a situation's pushes those that a walker can learn most from
are dealt most (as prioritised levels are: Jiang et al. 2021). Situations are kept apart since what is nothing
to one walker is too much for another: whose instruments are late, or who has just been pushed.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
from flax import struct
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

USUAL, LATE, SOON = range(3)
"""Situations: as configured, or with a circumstance that tells little; late instruments on weak motors; soon
after another push."""
SITUATIONS = 3
SIDES, SIZES, PHASES = 2, 8, 8
PUSHES = SIDES * SIZES * PHASES  # of a situation
CELLS = SITUATIONS * PUSHES
NONE = -1  # of no cell
MEMORY = 0.9995  # of what is counted, from one window to the next


class Course(struct.PyTreeNode):
    """What came of the pushes so far, the older the less it counts.

    Attributes:
      dealt: [CELLS] pushes. lost: [CELLS] those that ended in a fall, before the next one began.
    """

    dealt: Float[Array, "C"]
    lost: Float[Array, "C"]


class Dealt(struct.PyTreeNode):
    """A push that was drawn.

    Attributes:
      cell: its own. forward: from behind. size: from the least, 0, to the largest, 1, of its side.
      phase: of the step, 0..1.
    """

    cell: Int[Array, ""]
    forward: Bool[Array, ""]
    size: Float[Array, ""]
    phase: Float[Array, ""]


def start() -> Course:
    """Nothing is known."""
    return Course(jnp.zeros(CELLS), jnp.zeros(CELLS))


def even() -> np.ndarray:
    """[SITUATIONS, PUSHES] the shares of all alike."""
    return np.full((SITUATIONS, PUSHES), 1 / PUSHES, np.float32)


def shares(course: Course, focus: float) -> Float[Array, "S P"]:
    """[SITUATIONS, PUSHES] how often each is dealt in its situation: ``focus`` of all by the spread of its
    outcome, p (1 - p), p being the share that is lost; the rest alike."""
    lost = ((course.lost + 0.5) / (course.dealt + 1.0)).reshape(SITUATIONS, PUSHES)
    spread = lost * (1.0 - lost)
    return (1.0 - focus) / PUSHES + focus * spread / jnp.sum(spread, axis=1, keepdims=True)


def draw(shares: Float[Array, "S P"], situation: Int[Array, ""], key: PRNGKeyArray) -> Dealt:
    """A push of a cell that comes up in its situation as often as ``shares`` says, anywhere within it."""
    which, where = jax.random.split(key)
    cell = jnp.sum(jnp.cumsum(shares[situation]) < jax.random.uniform(which), dtype=jnp.int32)
    cell = jnp.minimum(cell, PUSHES - 1)
    within = jax.random.uniform(where, (2,))
    return Dealt(
        cell=situation * PUSHES + cell,
        forward=cell % SIDES == 0,
        size=(cell // SIDES % SIZES + within[0]) / SIZES,
        phase=(cell // (SIDES * SIZES) + within[1]) / PHASES,
    )


def counted(cells: Int[Array, "B"]) -> Float[Array, "C"]:
    """[CELLS] how often each is among ``cells``, which may be `NONE`."""
    return jnp.zeros(CELLS).at[jnp.where(cells < 0, CELLS, cells)].add(1.0, mode="drop")


def remembered(course: Course, dealt: Float[Array, "C"], lost: Float[Array, "C"]) -> Course:
    """``course`` a window further, with what it brought."""
    return Course(MEMORY * course.dealt + dealt, MEMORY * course.lost + lost)
