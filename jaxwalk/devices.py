"""The devices that walkers are split over."""

from __future__ import annotations

import jax
from jax.sharding import AxisType, Mesh

AXIS = "walkers"


def mesh(walkers: int | None = None) -> Mesh:
    """Devices along `AXIS`: all, or as many as ``walkers`` can be split evenly over."""
    count = jax.device_count()
    if walkers is not None:
        count = next(n for n in range(min(count, walkers), 0, -1) if walkers % n == 0)
    return jax.make_mesh((count,), (AXIS,), axis_types=(AxisType.Auto,), devices=jax.devices()[:count])
