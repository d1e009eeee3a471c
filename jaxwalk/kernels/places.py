"""Where `jax.lax.gather` takes entries from and `jax.lax.scatter` puts them; their indices are constants."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import jax
import numpy as np


def of_gather(
    shape: tuple[int, ...], where: np.ndarray, numbers: Any, sizes: Sequence[int], mode: Any
) -> np.ndarray:
    """For each entry that it takes, its place in the flattened operand; -1: outside of it.

    Args:
      shape: of the operand. where: its indices, the last axis along the operand's axes.
      numbers: `jax.lax.GatherDimensionNumbers`. sizes: of a slice. mode: `jax.lax.GatherScatterMode`.
    """
    ids, room = np.arange(math.prod(shape)).reshape(shape), np.subtract(shape, sizes)
    dropped = (*numbers.collapsed_slice_dims, *numbers.operand_batching_dims)
    rows = where.shape[:-1]
    taken = np.empty((*rows, *np.delete(sizes, dropped)), int)
    batching = [*zip(numbers.operand_batching_dims, numbers.start_indices_batching_dims, strict=True)]
    for row in np.ndindex(rows):
        start = np.zeros(len(shape), int)
        start[[*numbers.start_index_map]] = where[row]
        for axis, of_row in batching:
            start[axis] = row[of_row]
        if mode == jax.lax.GatherScatterMode.FILL_OR_DROP and ((start < 0) | (start > room)).any():
            taken[row] = -1
            continue
        begins = np.clip(start, 0, room)
        taken[row] = ids[tuple(slice(b, b + n) for b, n in zip(begins, sizes, strict=True))].squeeze(dropped)
    return np.moveaxis(taken, range(len(rows), taken.ndim), numbers.offset_dims)


def of_scatter(
    shape: tuple[int, ...], updates: tuple[int, ...], where: np.ndarray, numbers: Any, mode: Any
) -> np.ndarray:
    """For each entry of the updates, its place in the flattened operand; -1: outside of it.

    Args:
      updates: their shape. numbers: `jax.lax.ScatterDimensionNumbers`. The rest as for `of_gather`.
    """
    inserted = {*numbers.inserted_window_dims, *numbers.operand_batching_dims}
    window = iter(numbers.update_window_dims)
    sizes = [1 if axis in inserted else updates[next(window)] for axis in range(len(shape))]
    like = jax.lax.GatherDimensionNumbers(
        offset_dims=numbers.update_window_dims,
        collapsed_slice_dims=numbers.inserted_window_dims,
        start_index_map=numbers.scatter_dims_to_operand_dims,
        operand_batching_dims=numbers.operand_batching_dims,
        start_indices_batching_dims=numbers.scatter_indices_batching_dims,
    )
    return of_gather(shape, where, like, sizes, mode)
