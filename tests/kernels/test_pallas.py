"""A function in pieces, by Pallas' interpreter."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.kernels import pallas, pieces
from jaxwalk.kernels.entries import inputs
from jaxwalk.kernels.graph import Graph, known
from jaxwalk.kernels.unroll import unrolled

WALKERS = 70  # no multiple of a block


def state(x, flags, count):
    """Some of everything: truth values and whole numbers are handed on between pieces, too."""
    moved = jnp.sin(x) @ jnp.arange(9.0).reshape(3, 3) + x[0]
    low = moved < 0
    count = count + jnp.where(low[0], 3, 1) * 100_000_000
    for _ in range(3):
        moved = jnp.cos(moved) + jnp.where(low & flags, moved, x)
    return moved, ~low, count, x, 2.5 * jnp.ones(2)


SHAPES = [
    jax.ShapeDtypeStruct((3,), jnp.float32),
    jax.ShapeDtypeStruct((3,), bool),
    jax.ShapeDtypeStruct((), jnp.int32),
]


def unrolled_state():
    graph = Graph()
    given = inputs(graph, SHAPES)
    done = unrolled(graph, state, *given)
    return [[*x.flat] for x in given], [[*x.flat] for x in done]


@pytest.mark.parametrize("size", [8, 1000])
def test_pieces_are_complete_in_order_and_of_about_the_size(size):
    _, results = unrolled_state()
    wanted = [x for result in results for x in result]
    found = pieces.cut(wanted, size)
    assert len(found) > 3 or size > 100
    computed = set()
    for piece in found:
        assert len(piece.nodes) <= 1.25 * size
        there = {node.index for node in piece.takes if node.op == "input"} | computed
        assert all(node.op == "input" or node.index in computed for node in piece.takes)
        for node in piece.nodes:
            assert all(
                known(x) or x.index in there or x.index in {n.index for n in piece.takes} for x in node.args
            )
            there.add(node.index)
        computed |= {node.index for node in piece.gives}
    assert all(known(x) or x.op == "input" or x.index in computed for x in wanted)


@pytest.mark.parametrize("size", [8, 1000])
@pytest.mark.parametrize("reused", [{}, {0: 0, 1: 1, 2: 2}])
def test_kernels_compute_what_the_function_does(monkeypatch, size, reused):
    monkeypatch.setattr(pallas, "SIZE", size)
    run = pallas.kernels(*unrolled_state(), reused, interpret=True)
    rng = np.random.default_rng(0)
    x = jnp.asarray(rng.normal(size=(WALKERS, 3)), jnp.float32)
    flags, count = jnp.asarray(rng.random((WALKERS, 3)) < 0.5), jnp.arange(WALKERS, dtype=jnp.int32)
    found = jax.jit(run)([x.T, flags.T, count[None]])
    expected = jax.jit(jax.vmap(state))(x, flags, count)
    for ours, theirs in zip(found, expected, strict=True):
        theirs = theirs.reshape(WALKERS, -1).T
        assert ours.dtype == theirs.dtype
        np.testing.assert_allclose(ours, theirs, rtol=1e-5, atol=1e-6)


def test_a_kernel_is_compiled_once_for_each_piece():
    arguments, results = unrolled_state()
    text = str(
        jax.make_jaxpr(pallas.kernels(arguments, results))(
            [jnp.zeros((n, 64), d) for n, d in ((3, jnp.float32), (3, bool), (1, jnp.int32))]
        )
    )
    assert text.count("pallas_call[") == 1
