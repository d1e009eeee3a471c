"""What the learner learns from: one footstep, or a batch of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import jax

# A field of a pytree: an array whose shape the docstring gives. JAX also rebuilds pytrees from
# stacked arrays, shardings and placeholders, so that a checker of types must not insist.
Leaf = Any


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Transition:
    """One footstep; batches carry leading axes in every field.

    Attributes:
      observation: [O], raw (not normalised), in the units of each observable.
      action: [A], what was done, in [-1, 1].
      reward: [].
      discount: [], the weight of what follows: gamma, or 0 where the walker fell. gamma is
        already inside; a walker that was merely stopped (truncation) keeps gamma.
      next_observation: [O], raw.
    """

    observation: Leaf
    action: Leaf
    reward: Leaf
    discount: Leaf
    next_observation: Leaf
