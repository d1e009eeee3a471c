"""Small systems of equations with a symmetric positive definite matrix, for many walkers at once.

LAPACK is called once for each walker, and a matrix of nine rows is over before the call is. Here the whole
batch is eliminated together.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float


def solve(matrix: Float[Array, "N N B"], vector: Float[Array, "N B"]) -> Float[Array, "N B"]:
    """x of ``matrix`` x = ``vector``, walkers along the last axis.

    From the last row to the first, which between a robot's leaves and its root keeps zeros that are there.
    Gauss and Jordan's elimination, without a search for pivots, which such matrices do not need. That they
    are symmetric and positive definite is not checked.
    """
    left = jax.lax.optimization_barrier(jnp.concatenate([matrix[::-1, ::-1], vector[::-1, None]], axis=1))
    size = left.shape[0]
    for row in range(size):
        pivot = 1 / left[row, 0]
        others = left[:, 1:] - pivot * (left[:, :1] * left[row, 1:])
        here = (jnp.arange(size) == row)[:, None, None]
        # XLA would fuse the rows' steps and compute each again for every element of the next.
        left = jax.lax.optimization_barrier(jnp.where(here, pivot * left[row, 1:], others))
    return left[::-1, 0]


@jax.custom_batching.custom_vmap
def solve_one(matrix: Float[Array, "N N"], vector: Float[Array, "N"]) -> Float[Array, "N"]:
    """`solve` of one walker; under `jax.vmap`, of all of them together."""
    return solve(matrix[..., None], vector[..., None])[..., 0]


@solve_one.def_vmap
def _solve_many(
    size: int, batched: list[bool], matrix: Float[Array, "..."], vector: Float[Array, "..."]
) -> tuple[Float[Array, "B N"], bool]:
    last = (
        jnp.moveaxis(x, 0, -1) if one else jnp.broadcast_to(x[..., None], (*x.shape, size))
        for x, one in zip((matrix, vector), batched, strict=True)
    )
    return jnp.moveaxis(solve(*last), -1, 0), True
