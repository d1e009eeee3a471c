"""XLA's cost of a program, its loops counted as often as they turn."""

import jax
import jax.numpy as jnp
import pytest

from jaxwalk.measure.bench import costs

N = 64
PRODUCT = 2 * N**3  # flops
MATRIX = 4 * N**2  # bytes


def cost(function, *args, solver=1.0, others=1.0):
    found = costs.of(jax.jit(function).lower(*args).compile(), solver, others)
    assert found is not None
    return found


def test_a_product_of_matrices():
    found = cost(lambda x: x @ x, jnp.ones((N, N)))
    assert found.flops == pytest.approx(PRODUCT, rel=0.01)
    assert 2 * MATRIX <= found.bytes <= 3 * MATRIX  # read once or twice, written once


def test_loops_within_loops_turn_as_often_as_they_do():
    def nested(x):
        def once(x, _):
            return jax.lax.fori_loop(0, 7, lambda _, y: x @ y, x), None

        return jax.lax.scan(once, x, length=5)[0] @ x

    single = cost(lambda x: x @ x, jnp.ones((N, N)))
    found = cost(nested, jnp.ones((N, N)))
    assert found.flops == pytest.approx((5 * 7 + 1) * PRODUCT, rel=0.01)
    assert found.bytes >= 36 * 2 * MATRIX and found.bytes < 36 * 4 * single.bytes


def test_a_loop_that_its_data_end_turns_as_often_as_is_told():
    def ticks(x, most):
        """A solver, scoped as MJX's, in a loop of 4 ticks."""

        @jax.named_scope("solve")
        def solve(y):
            return jax.lax.while_loop(lambda s: jnp.sum(s) < most, lambda s: s @ s, y)

        return jax.lax.fori_loop(0, 4, lambda _, y: solve(y), x)

    def training(x, due):
        return jax.lax.fori_loop(0, due, lambda _, y: y @ x, ticks(x, 1.0))

    found = cost(ticks, jnp.ones((N, N)), 1.0, solver=3.0, others=100.0)
    assert found.flops == pytest.approx(4 * 3 * PRODUCT, rel=0.05)  # and the sums
    found = cost(training, jnp.ones((N, N)), 9, solver=3.0, others=100.0)
    assert found.flops == pytest.approx((4 * 3 + 100) * PRODUCT, rel=0.05)


def test_of_two_branches_the_dearer_counts():
    def either(x, which):
        def turn(times):
            return lambda y: jax.lax.fori_loop(0, times, lambda _, z: z @ x, y)

        return jax.lax.cond(which, turn(3), turn(11), x)

    assert cost(either, jnp.ones((N, N)), True).flops == pytest.approx(11 * PRODUCT, rel=0.01)


def test_kernels_tell_their_costs_themselves():
    """As they stand in the text of a program for CUDA, twice, of a batch of 4,096."""
    kernel = (
        '  %k.{} = f32[9,4096]{{1,0}} custom-call(%x), custom_call_target="__gpu$xla.gpu.triton", '
        "backend_config="
        '{{name = "kernel", num_warps = 2 : i32, serialized_metadata = '
        '"{{\\22flops\\22: \\22{}\\22, \\22bytes\\22: \\22{}\\22}}"}}'
    )
    text = "\n".join(
        [kernel.format(1, 5906432, 3375104), "  %y = f32[2]{0} add(%a, %b)", kernel.format(2, 8, 4)]
    )
    assert costs._kernels(text) == costs.Cost(5906440.0, 3375108.0)
