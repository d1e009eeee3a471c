"""What is unrolled computes what JAX computes."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.kernels import emit
from jaxwalk.kernels.entries import inputs
from jaxwalk.kernels.graph import OPERATIONS, Graph, Unsupported, known, reach
from jaxwalk.kernels.unroll import unrolled


def computed(function, *args):
    """``function`` unrolled, then evaluated; and how many operations that took."""
    graph = Graph()
    args = jax.tree.map(jnp.asarray, args)
    given = inputs(graph, args)
    done = unrolled(graph, function, *given)
    leaves, tree = jax.tree.flatten(done)
    nodes = reach([x for leaf in leaves for x in leaf.flat])
    values = {
        node.index: number
        for leaf, array in zip(jax.tree.leaves(given), jax.tree.leaves(args), strict=True)
        for node, number in zip(leaf.flat, array.reshape(-1), strict=True)
    }
    emit.emit(nodes, values, ())
    results = [
        np.array([emit.value(x, values, ()) for x in leaf.flat]).reshape(leaf.shape) for leaf in leaves
    ]
    return jax.tree.unflatten(tree, results), len(nodes)


X = np.random.default_rng(0).normal(size=(3, 4)).astype(np.float32)
V = np.random.default_rng(1).normal(size=4).astype(np.float32)


@pytest.mark.parametrize(
    "function",
    [
        lambda x, v: x @ v + jnp.sin(v)[:3],
        lambda x, v: jnp.einsum("ij,ik->jk", x, x) / (1 + v**2),
        lambda x, v: jnp.asarray(x)[jnp.array([2, 0])].at[:, 1].set(v[:2]).at[0, 2].add(v[3]),
        lambda x, v: jnp.zeros((3, 4)).at[jnp.array([0, 0, 2])].add(x),
        lambda x, v: jnp.where(x > 0, x, v) ** 3,
        lambda x, v: (jnp.max(x, 0), jnp.min(x), jnp.sum(x, (0, 1)), jnp.all(x < 9), jnp.any(x > 9)),
        lambda x, v: jnp.concatenate([jnp.flip(x, 1), jnp.tile(v, (2, 1))]).T,
        lambda x, v: jnp.pad(v, (1, 2)) * jnp.stack([v[0]] * 7),
        lambda x, v: (jnp.unstack(v), jnp.unstack(x, axis=1), jnp.split(x, [1, 3], axis=1)),
        lambda x, v: jnp.clip(jnp.cross(x[:, :3], v[:3]), -0.5, 0.5),
        lambda x, v: jax.vmap(jnp.dot, (0, None))(x, v).astype(jnp.int32).astype(jnp.float32),
        lambda x, v: (jnp.dot(v, v), jnp.max((9 * x).astype(int), 0), jnp.sum(x[:0], 0), jnp.sign(x)),
        lambda x, v: ((9 * x).astype(int) & 6) | 2,
        lambda x, v: jnp.take(v, jnp.array([1, -1, 7, -9]), mode="fill", fill_value=5.0),
        lambda x, v: jnp.take(x, jnp.array([[1, 9], [-1, 0]]), axis=1, mode="clip"),
        lambda x, v: jnp.asarray(x).at[jnp.array([0, 5, 1]), jnp.array([1, 1, 3])].multiply(v[:3]),
        lambda x, v: jax.vmap(lambda row, i: row.at[i].set(v[0]))(x, jnp.array([2, 0, 3])),
        lambda x, v: jnp.linalg.norm(x, axis=1) + jnp.arctan2(v[0], v[1]) + jnp.exp(v[2]),
    ],
)
def test_functions_of_arrays(function):
    found, _ = computed(function, X, V)
    for ours, theirs in zip(jax.tree.leaves(found), jax.tree.leaves(function(X, V)), strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("place", [-1, 0, 1, 2, 7])
def test_an_index_that_only_the_run_knows_is_clamped_as_jax_does(place):
    def row(x, i):
        return jax.lax.dynamic_slice(x, (i, 1), (1, 2))

    found, _ = computed(row, X, np.int32(place))
    np.testing.assert_array_equal(found, row(X, place))


def test_structural_zeros_cost_nothing():
    """A matrix of two blocks of two rows, times a vector: eight products, four sums."""

    def product(left, right, v):
        whole = jnp.zeros((4, 4)).at[:2, :2].set(left).at[2:, 2:].set(right)
        return whole @ v

    _, count = computed(product, X[:2, :2], X[1:, :2], V)
    assert count == 8 + 4


def test_what_nobody_reads_is_not_computed():
    _, count = computed(lambda x, v: (jnp.linalg.cholesky(x @ x.T), v[0] + v[1])[1], X, V)
    assert count == 1


def test_a_loop_is_refused_by_name():
    with pytest.raises(Unsupported, match="while"):
        computed(lambda v: jax.lax.while_loop(lambda x: x[0] < 9, lambda x: x + 1, v), V)


@pytest.mark.parametrize(
    "function, why",
    [
        (lambda v: jnp.asarray(v).at[0].apply(jnp.sin), "by a function"),
        (lambda v: jax.lax.round(v), "round"),
        (lambda v: jnp.max(v[:0], initial=-jnp.inf), "max of nothing"),
        (lambda v: jnp.sort(v), "sort"),
    ],
)
def test_what_has_no_rule_is_refused_by_name(function, why):
    with pytest.raises(Unsupported, match=why):
        computed(function, V)


def test_every_operation_of_a_graph_can_be_emitted():
    assert OPERATIONS.keys() <= emit.OPERATIONS.keys()


def test_keys_are_handed_on():
    graph = Graph()
    key = jax.eval_shape(lambda: jax.random.key(0))
    given = inputs(graph, (key, jax.ShapeDtypeStruct((), bool)))
    done = unrolled(graph, lambda key, flag: jnp.where(flag, key, key), *given)
    assert not known(done[()]) and done[()] is given[0][()]
