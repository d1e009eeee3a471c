"""The tick of a walker, unrolled, is the tick."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import ticks

from jaxwalk.config import Config
from jaxwalk.config.presets import PRESETS
from jaxwalk.control import walker
from jaxwalk.control.person import model_of
from jaxwalk.kernels import emit, fused, pallas
from jaxwalk.kernels.entries import inputs
from jaxwalk.kernels.graph import Graph, Unsupported, reach
from jaxwalk.kernels.unroll import unrolled
from jaxwalk.model import engine
from jaxwalk.task import collect, footstep, spawn, stepper
from jaxwalk.task.stepper import Task

WALKERS, WINDOWS = 8, 40


@pytest.fixture(scope="module")
def task() -> Task:
    return Task.of(Config())


@pytest.fixture(scope="module")
def walked(task):
    """Walkers in all phases of a step, some of them pushed, and their noise."""

    def windows_on(key):
        state = spawn.walker(Config(), task, key)

        def window(_, state):
            state = stepper.decide(state, footstep.nominal_action(state.walker.person))
            return collect.run_ticks(task, state, task.setup.window_ticks)

        return jax.lax.fori_loop(0, WINDOWS, window, state)

    states = jax.jit(jax.vmap(windows_on))(jax.random.split(jax.random.key(3), WALKERS))
    return states, jax.vmap(lambda s: walker.noise(s.walker, 1)[0])(states)


def evaluated(function, *args):
    """``function`` of many, through its graph, one operation after another."""
    leaves, tree = jax.tree.flatten(args)
    graph = Graph()
    given = inputs(graph, [jax.ShapeDtypeStruct(x.shape[1:], x.dtype) for x in leaves])
    done, form = jax.tree.flatten(unrolled(graph, function, *jax.tree.unflatten(tree, given)))
    values = {}
    for entries, x in zip(given, leaves, strict=True):
        if jnp.issubdtype(x.dtype, jax.dtypes.prng_key):
            x = jnp.zeros(WALKERS)  # nobody asks for their values
        columns = x.reshape(WALKERS, -1).T
        values |= {node.index: column for node, column in zip(entries.flat, columns, strict=True)}
    nodes = reach([x for leaf in done for x in leaf.flat])
    emit.emit(nodes, values, (WALKERS,))
    results = [
        np.stack([emit.value(x, values, (WALKERS,)) for x in leaf.flat], 1).reshape(WALKERS, *leaf.shape)
        for leaf in done
    ]
    return jax.tree.unflatten(form, results), nodes


def test_a_tick_by_its_graph_is_the_tick(task, walked):
    states, white = walked
    found, nodes = evaluated(partial(stepper._tick, task), states, white)
    many = jax.tree.map(lambda x: x[np.resize(np.arange(WALKERS), ticks.WALKERS)], states)
    expected = jax.tree.map(lambda x: x[:WALKERS], ticks.by_xla(task)(many))
    assert len(nodes) < 15_000  # 12,777 when it was written: it must not grow unseen
    for (path, theirs), ours in zip(jax.tree.leaves_with_path(expected), jax.tree.leaves(found), strict=True):
        if jnp.issubdtype(theirs.dtype, jax.dtypes.prng_key):
            continue
        # Contacts are stiff: the soles' forces differ most.
        scale = max(1.0, float(jnp.max(jnp.abs(theirs.astype(jnp.float32)))))
        np.testing.assert_allclose(
            np.asarray(ours, np.float64) / scale, np.asarray(theirs, np.float64) / scale, atol=2e-4,
            err_msg=jax.tree_util.keystr(path),
        )  # fmt: skip


def test_what_a_tick_leaves_alone_is_handed_on_unread(task, walked):
    states, white = walked
    leaves, tree = jax.tree.flatten(jax.tree.map(lambda x: x[0], (states, white)))
    program = fused.program_of(stepper._tick, task, tree, tuple((x.shape, x.dtype) for x in leaves), False)
    names = [jax.tree_util.keystr(path) for path, _ in jax.tree.leaves_with_path(states)]
    same = {name for name, one in zip(names, program.same, strict=True) if one is not None}
    assert ".walker.key" in same
    assert any(name.startswith(".walker.person.gait") for name in same)
    assert ".walker.plant.qpos" not in same


@pytest.fixture
def interpreted(monkeypatch):
    """Kernels run by Pallas' interpreter."""
    made = pallas.kernels
    monkeypatch.setattr(pallas, "kernels", partial(made, interpret=True))
    yield
    fused.program_of.cache_clear()


def go_on(power, state, other):
    """A state that goes on: a key, parts that change, that change places, and that stay."""
    key, x, y, count = state
    return key, y + 0, x**power + other, count + 1


@pytest.mark.parametrize("walkers", [1, 64, 70])
def test_under_vmap_a_function_is_computed_by_its_kernels(interpreted, walkers):
    rng = np.random.default_rng(0)
    x, y = jnp.asarray(rng.normal(size=(2, walkers, 3)), jnp.float32)
    state = (jax.random.split(jax.random.key(0), walkers), x, y, jnp.arange(walkers))
    other = jnp.ones(3)  # the same for all
    many = jax.vmap(lambda state, other: fused.fused(go_on, 2, state, other), in_axes=(0, None))
    found = jax.jit(lambda s: jax.lax.fori_loop(0, 2, lambda _, s: many(s, other), s))(state)
    assert (found[0] == state[0]).all()
    np.testing.assert_allclose(found[1], x**2 + 1, rtol=1e-6)
    np.testing.assert_allclose(found[2], y**2 + 1, rtol=1e-6)
    np.testing.assert_array_equal(found[3], np.arange(walkers) + 2)
    assert "pallas_call" in str(jax.make_jaxpr(lambda s: many(s, other))(state))


def test_seeds_and_walkers_are_mapped_over_at_once(interpreted):
    x = jnp.arange(24.0).reshape(2, 4, 3)
    found = jax.jit(jax.vmap(jax.vmap(lambda x: fused.fused(halves, None, x))))(x)
    np.testing.assert_array_equal(found[0], x[..., :1] / 2)
    np.testing.assert_array_equal(found[1], x > 5)


def halves(_, x):
    """Results of other shapes and types than the argument."""
    return x[:1] / 2, x > 5


@pytest.mark.parametrize("empty", [0, 1])
def test_what_is_empty_is_refused(interpreted, empty):
    with pytest.raises(Unsupported, match="empty"):
        jax.vmap(lambda x: fused.fused(lambda _, x: x[:0], None, x))(jnp.ones((4, 1 - empty)))


@pytest.mark.parametrize("preset", ["default", pytest.param("paper", marks=pytest.mark.slow)])
def test_presets_have_kernels_for_cuda(monkeypatch, preset):
    """Lowered as far as goes without a GPU: Triton knows all operations."""
    config = PRESETS[preset]
    task = Task.of(config)
    monkeypatch.setattr(engine, "on_gpu", lambda setup: True)
    state = jax.eval_shape(partial(spawn.walker, config, task), jax.random.key(0))
    many = jax.tree.map(lambda x: jax.ShapeDtypeStruct((64, *x.shape), x.dtype), state)
    tick = jax.jit(jax.vmap(lambda s: stepper.tick(task, model_of(task.setup, s.walker.person), s)))
    text = tick.trace(many).lower(lowering_platforms=("cuda",)).as_text()
    assert 5 < text.count("xla.gpu.triton") < 15
