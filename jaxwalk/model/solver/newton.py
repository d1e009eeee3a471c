"""Constraint forces by Newton's method with an exact line search, for a batch of walkers at a time.

The problem is MuJoCo's own (documentation, "Computation", the primal problem with pyramidal cones): the
acceleration x that minimises

    (x - smooth)' M (x - smooth) / 2  +  sum over rows of D min(0, J x - aref)^2 / 2.

MuJoCo's solvers, MJX's included, search along each direction by trial. But the slope along it is piecewise
linear, with a corner where a row begins or ceases to press, so that its zero is found at once.

Within, walkers lie along the last axis, where a core's vector units find them: products of many matrices of
nine rows would take longer to call than to compute.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.model.solver import spd

WRITTEN_OUT = 8
"""So few steps are no loop, which would cost more than it holds, and could not be unrolled for kernels."""


class Problem(NamedTuple):
    """What is minimised, for N degrees of freedom and R unilateral rows of one walker.

    Attributes:
      mass: [N, N] joint-space inertia M.
      smooth: [N] acceleration without constraints.
      jacobian: [R, N] J. stiffness: [R] D. reference: [R] aref.
    """

    mass: Float[Array, "N N *B"]
    smooth: Float[Array, "N *B"]
    jacobian: Float[Array, "R N *B"]
    stiffness: Float[Array, "R *B"]
    reference: Float[Array, "R *B"]


class _Point(NamedTuple):
    """Where the search is: x, and at x the momentum M (x - smooth) and the rows' J x - aref."""

    x: Float[Array, "N B"]
    momentum: Float[Array, "N B"]
    rows: Float[Array, "R B"]


def minimize(
    problem: Problem, start: Float[Array, "N"], iterations: int
) -> tuple[Float[Array, "N"], Float[Array, "R"]]:
    """The acceleration of one walker, and the force of each row at it.

    Args:
      start: where the search begins, unless ``smooth`` is the better of the two.
      iterations: Newton steps, none of which is left out: a batch waits for its last walker anyway.
    """

    @jax.custom_batching.custom_vmap
    def solved(problem: Problem, start: Array) -> tuple[Array, Array]:
        one = jax.tree.map(lambda x: x[..., None], (problem, start))
        return jax.tree.map(lambda x: x[..., 0], _minimized(*one, iterations=iterations))

    @solved.def_vmap
    def _(size: int, batched: Any, problem: Problem, start: Array) -> tuple[Any, Any]:
        many = jax.tree.map(
            lambda x, one: (
                jnp.moveaxis(x, 0, -1) if one else jnp.broadcast_to(x[..., None], (*x.shape, size))
            ),
            (problem, start),
            tuple(batched),
        )
        found = _minimized(*many, iterations=iterations)
        return jax.tree.map(lambda x: jnp.moveaxis(x, -1, 0), found), (True, True)

    return solved(problem, start)


def _minimized(problem: Problem, start: Float[Array, "N B"], iterations: int) -> tuple[Array, Array]:
    begun, free = _point(problem, start), _point(problem, problem.smooth)
    warm = _cost(problem, begun) < _cost(problem, free)
    point = jax.tree.map(lambda a, b: jnp.where(warm, a, b), begun, free)
    if iterations > WRITTEN_OUT:
        point = jax.lax.fori_loop(0, iterations, lambda _, p: _newton(problem, p), point)
    else:
        for _ in range(iterations):
            point = _newton(problem, point)
    return point.x, _forces(problem, point)


def _point(problem: Problem, x: Float[Array, "N B"]) -> _Point:
    return _Point(
        x, _times(problem.mass, x - problem.smooth), _times(problem.jacobian, x) - problem.reference
    )


def _total(terms: Iterable[Array]) -> Array:
    """A sum written out: a reduction of so few terms takes XLA's CPU ten times as long."""
    return functools.reduce(jnp.add, terms)


def _times(matrix: Float[Array, "M N B"], vector: Float[Array, "N B"]) -> Float[Array, "M B"]:
    return _total(matrix[:, k] * vector[k] for k in range(vector.shape[0]))


def _cost(problem: Problem, point: _Point) -> Float[Array, "B"]:
    pressed = jnp.minimum(point.rows, 0.0)
    momentum = _total((point.x - problem.smooth) * point.momentum)
    return 0.5 * (momentum + _total(problem.stiffness * pressed * pressed))


def _forces(problem: Problem, point: _Point) -> Float[Array, "R B"]:
    return problem.stiffness * jnp.maximum(-point.rows, 0.0)


def _newton(problem: Problem, point: _Point) -> _Point:
    pressing = jnp.where(point.rows < 0, problem.stiffness, 0.0)
    forces = _forces(problem, point)
    gradient = point.momentum - _total(
        row * force for row, force in zip(problem.jacobian, forces, strict=True)
    )
    hessian = problem.mass + _total(
        weight * (row[:, None] * row) for row, weight in zip(problem.jacobian, pressing, strict=True)
    )
    ahead = -spd.solve(hessian, gradient)
    along = _Point(ahead, _times(problem.mass, ahead), _times(problem.jacobian, ahead))
    step = line_search(
        _total(ahead * point.momentum),
        _total(ahead * along.momentum),
        point.rows,
        along.rows,
        problem.stiffness,
    )
    return jax.tree.map(lambda at, to: at + step * to, point, along)


def line_search(
    slope: Float[Array, "B"],
    curvature: Float[Array, "B"],
    rows: Float[Array, "R B"],
    rates: Float[Array, "R B"],
    stiffness: Float[Array, "R B"],
) -> Float[Array, "B"]:
    """a >= 0 of least cost: the zero of ``slope`` + a ``curvature`` + sum D rate min(0, row + a rate).

    It never falls with a: its corners tell between which two of them it changes sign; there it is a line.

    Args:
      slope, curvature: of the quadratic part, at a = 0.
      rows, rates, stiffness: of each row, its value at a = 0, its change with a, and D.
    """
    moving = rates != 0
    corners = jnp.where(moving, -rows / jnp.where(moving, rates, 1.0), 0.0)
    corners = jnp.concatenate([jnp.zeros((1, *slope.shape)), jnp.maximum(corners, 0.0)])
    pushed = stiffness * rates
    values = (
        slope
        + corners * curvature
        + _total(
            one * jnp.minimum(0.0, row + corners * rate)
            for one, row, rate in zip(pushed, rows, rates, strict=True)
        )
    )
    # (corner, value) of the last before the zero, and of the first behind it: neither ever falls.
    before = values <= 0
    low, low_value = (
        jnp.max(jnp.where(before, corners, 0.0), 0),
        jnp.max(jnp.where(before, values, -jnp.inf), 0),
    )
    high = jnp.min(jnp.where(before, jnp.inf, corners), 0)
    high_value = jnp.min(jnp.where(before, jnp.inf, values), 0)
    # Beyond the last corner those rows press that move down.
    last = curvature + _total(stiffness * jnp.square(jnp.minimum(rates, 0.0)))
    rise = jnp.where(jnp.isfinite(high), (high_value - low_value) / (high - low), last)
    # At the minimum itself there is nowhere to go, and perhaps no slope at all.
    there = (low_value >= 0) | ~jnp.isfinite(low_value) | ~(rise > 0)
    return jnp.where(there, low, low - low_value / jnp.where(there, 1.0, rise))
