"""Newton's method: where it ends is the minimum, by conditions and by a solver that knows nothing of it."""

from __future__ import annotations

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.optimize import minimize

from jaxwalk.model.solver import newton, spd
from jaxwalk.model.solver.newton import Problem

BATCH, DOFS, ROWS = 5, 9, 16


def problems(seed=0):
    """[BATCH] of them, as stiff as a foot on a floor, and where to begin."""
    rng = np.random.default_rng(seed)
    half = rng.normal(size=(BATCH, DOFS, DOFS))
    arrays = (
        half @ half.transpose(0, 2, 1) + DOFS * np.eye(DOFS),
        rng.normal(size=(BATCH, DOFS)),
        rng.normal(size=(BATCH, ROWS, DOFS)),
        10 ** rng.uniform(0, 4, (BATCH, ROWS)),
        rng.normal(size=(BATCH, ROWS)),
    )
    return Problem(*(jnp.asarray(x, jnp.float32) for x in arrays)), jnp.zeros((BATCH, DOFS))


def of(batch, i):
    return [np.asarray(x[i], np.float64) for x in batch]


def cost(x, mass, smooth, jacobian, stiffness, reference):
    pressed = np.minimum(0, jacobian @ x - reference)
    return (x - smooth) @ mass @ (x - smooth) / 2 + stiffness @ pressed**2 / 2


@partial(jax.jit, static_argnums=2)
def solve(batch, start, iterations):
    return jax.vmap(lambda p, s: newton.minimize(p, s, iterations))(batch, start)


def test_it_ends_at_the_minimum_that_a_general_solver_finds():
    batch, start = problems()
    found, forces = solve(batch, start, 8)
    for i in range(BATCH):
        one = of(batch, i)
        mass, smooth, jacobian = one[:3]
        best = minimize(cost, smooth, tuple(one), method="BFGS", options={"gtol": 1e-9})
        assert cost(np.asarray(found[i], float), *one) <= best.fun * (1 + 1e-5)
        np.testing.assert_allclose(found[i], best.x, atol=2e-3)
        # No force is left over, and rows only press.
        rest = mass @ (np.asarray(found[i]) - smooth) - jacobian.T @ np.asarray(forces[i])
        assert np.abs(rest).max() < 1e-3 * np.abs(jacobian.T @ np.asarray(forces[i])).max()
        assert (np.asarray(forces[i]) >= 0).all()


def test_three_iterations_leave_little():
    batch, start = problems(1)
    found = {n: np.asarray(solve(batch, start, n)[0], float) for n in (0, 1, 3, 20)}
    costs = {n: [cost(x, *of(batch, i)) for i, x in enumerate(each)] for n, each in found.items()}
    assert np.all(np.diff([costs[n] for n in (0, 1, 3)], axis=0) < 0)
    assert np.all(np.array(costs[3]) - costs[20] < 0.01 * (np.array(costs[0]) - costs[20]))


def test_it_begins_at_the_better_of_two_starts():
    batch, start = problems()
    best = solve(batch, start, 20)[0]
    np.testing.assert_array_equal(solve(batch, best, 0)[0], best)  # warm
    np.testing.assert_array_equal(solve(batch, best + 100.0, 0)[0], batch.smooth)  # worse than none


def test_one_walker_is_solved_as_many_are():
    batch, start = problems()
    many, alone = solve(batch, start, 3), jax.jit(newton.minimize, static_argnums=2)
    for i in range(BATCH):
        one = alone(jax.tree.map(lambda x, i=i: x[i], batch), start[i], 3)
        jax.tree.map(lambda a, b, i=i: np.testing.assert_allclose(a[i], b, rtol=1e-3, atol=1e-3), many, one)


def test_free_of_rows_the_acceleration_is_the_smooth_one():
    batch, start = problems()
    free = batch._replace(jacobian=jnp.zeros_like(batch.jacobian), reference=jnp.zeros_like(batch.reference))
    found, forces = solve(free, start + 5.0, 3)
    np.testing.assert_allclose(found, batch.smooth, atol=1e-5)
    assert not np.any(forces)


@pytest.mark.parametrize(
    ("slope", "curvature", "rows", "rates", "stiffness", "zero"),
    [
        (-2.0, 4.0, [1.0], [0.0], [9.0], 0.5),  # no row in the way
        (-2.0, 1.0, [1.0], [-1.0], [9.0], 1.1),  # one presses from a = 1 on: -2 + a + 9 (a - 1) = 0
        (-2.0, 1.0, [-1.0], [0.5], [1.0], 2.0),  # one lets go at a = 2, where -2.5 + 1.25 a = 0, too
        (-1.0, 0.5, [3.0, 5.0], [-1.0, -1.0], [1e4, 1e4], 2.0),  # both too far away
        (0.0, 1.0, [1.0], [-1.0], [1.0], 0.0),  # there already
        (1.0, 1.0, [1.0], [-1.0], [1.0], 0.0),  # no way down
    ],
)
def test_the_line_search_is_exact(slope, curvature, rows, rates, stiffness, zero):
    told = [jnp.asarray(x, jnp.float32)[..., None] for x in (slope, curvature, rows, rates, stiffness)]
    # In the third, the row's own slope is part of the whole at a = 0: sum D rate min(0, row) = -0.5.
    assert float(jax.jit(newton.line_search)(*told)[0]) == pytest.approx(zero, abs=1e-5)


def test_small_systems_are_solved_alone_and_together():
    batch, _ = problems()
    truth = np.linalg.solve(np.asarray(batch.mass, float), np.asarray(batch.smooth, float)[..., None])[..., 0]
    together = jax.jit(jax.vmap(spd.solve_one))(batch.mass, batch.smooth)
    np.testing.assert_allclose(together, truth, rtol=1e-4, atol=1e-6)
    alone = jax.jit(spd.solve_one)(batch.mass[2], batch.smooth[2])
    np.testing.assert_allclose(alone, truth[2], rtol=1e-4, atol=1e-6)
    # One matrix for many vectors; a batch of batches.
    shared = jax.jit(jax.vmap(spd.solve_one, in_axes=(None, 0)))(batch.mass[2], batch.smooth)
    np.testing.assert_allclose(shared[2], truth[2], rtol=1e-4, atol=1e-6)
    twice = jax.jit(jax.vmap(jax.vmap(spd.solve_one)))(batch.mass[None], batch.smooth[None])
    np.testing.assert_allclose(twice[0], truth, rtol=1e-4, atol=1e-6)
