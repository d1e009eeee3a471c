"""The tick of a walker, unrolled, is the tick."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk import footstep, stepper, walker, windows
from jaxwalk.config import Config
from jaxwalk.kernels import emit, fused
from jaxwalk.kernels.graph import Graph, reach
from jaxwalk.kernels.unroll import inputs, unrolled
from jaxwalk.stepper import Task

WALKERS, WINDOWS = 8, 40


@pytest.fixture(scope="module")
def task() -> Task:
    return Task.of(Config())


@pytest.fixture(scope="module")
def walked(task):
    """Walkers in all phases of a step, some of them pushed, and their noise."""

    def windows_on(key):
        state = windows.spawn(Config(), task, key)

        def window(_, state):
            state = stepper.decide(state, footstep.nominal_action(state.walker.person))
            return windows.run_ticks(task, state, task.setup.window_ticks)

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
    nodes = reach([x for leaf in done for x in leaf.flat]).nodes
    emit.emit(nodes, values, (WALKERS,))
    results = [
        np.stack([emit.value(x, values, (WALKERS,)) for x in leaf.flat], 1).reshape(WALKERS, *leaf.shape)
        for leaf in done
    ]
    return jax.tree.unflatten(form, results), nodes


def test_a_tick_by_its_graph_is_the_tick(task, walked):
    states, white = walked
    tick = partial(stepper._tick, task)
    found, nodes = evaluated(tick, states, white)
    expected = jax.jit(jax.vmap(tick))(states, white)
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
    program = fused._program(stepper._tick, task, tree, tuple((x.shape, x.dtype) for x in leaves))
    names = [jax.tree_util.keystr(path) for path, _ in jax.tree.leaves_with_path(states)]
    same = {name for name, one in zip(names, program.same, strict=True) if one is not None}
    assert ".walker.key" in same
    assert any(name.startswith(".walker.person.gait") for name in same)
    assert ".walker.plant.qpos" not in same


def test_processors_run_no_kernels():
    config = Config()
    assert fused.usable(config.body, config.physics) == (jax.default_backend() == "gpu")
