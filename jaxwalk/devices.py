"""The devices that walkers are split over."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
from jax.sharding import AxisType, Mesh, PartitionSpec

AXIS = "walkers"


def mesh(walkers: int | None = None) -> Mesh:
    """Devices along `AXIS`: all, or as many as ``walkers`` can be split evenly over."""
    count = jax.device_count()
    if walkers is not None:
        count = next(n for n in range(min(count, walkers), 0, -1) if walkers % n == 0)
    return jax.make_mesh((count,), (AXIS,), axis_types=(AxisType.Auto,), devices=jax.devices()[:count])


def spread(function: Callable[..., Any], mesh: Mesh, split: tuple[bool, ...]) -> Callable[..., Any]:
    """``function`` of walkers, compiled to run on all of ``mesh``; its last argument is given up to it.

    Args:
      function: its result's arrays all have a leading axis of walkers.
      split: for each argument, whether it has that axis too; what has none is the same everywhere.
    """
    specs = tuple(PartitionSpec(AXIS) if one else PartitionSpec() for one in split)
    mapped = jax.shard_map(
        function, mesh=mesh, in_specs=specs, out_specs=PartitionSpec(AXIS), check_vma=False
    )
    return jax.jit(mapped, donate_argnums=len(split) - 1)
