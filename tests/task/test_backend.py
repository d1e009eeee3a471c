"""Walkers go the same way by native code as by XLA, and the program says which it is."""

import dataclasses
import functools
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import ticks

from jaxwalk.common.errors import UserError
from jaxwalk.config import BodyConfig, Config, PhysicsConfig
from jaxwalk.config.presets import PRESETS
from jaxwalk.control import walker
from jaxwalk.control.person import Person
from jaxwalk.kernels import compiler, native, walk
from jaxwalk.kernels.graph import Unsupported
from jaxwalk.model import engine, physics
from jaxwalk.model.engine import Setup
from jaxwalk.model.solver import dynamics
from jaxwalk.task import backend, env, footstep, rollout, scenarios, spawn, stepper, trials
from jaxwalk.task.stepper import Task

PLANAR, RIGID, WALLS = Config(), PRESETS["rigid"], Config(body=BodyConfig(model="walls"))


@functools.cache
def walked(config, walkers=ticks.WALKERS):
    """Walkers of all ages, phases, sizes and pushes, none of them lying."""
    task = Task.of(config)

    def answer(state):  # rigid legs walk at their nominal step, compliant ones change what they plan
        rigid = config.gait.form == "rigid"
        change = 0.4 * jnp.sin(9.0 * state.observation[3:5])
        return footstep.nominal_action(state.walker.person) if rigid else change

    def on(key):
        state = spawn.walker(config, task, key)

        def window(_, state):
            state = stepper.decide(state, answer(state))
            return walk.scan(stepper.alone, task, 10, state)[0]

        return jax.lax.fori_loop(0, jax.random.randint(key, (), 1, 200), window, state)

    states = jax.jit(jax.vmap(on))(jax.random.split(jax.random.key(5), walkers))
    up = np.flatnonzero(~np.asarray(states.done))
    assert up.size > 0.8 * walkers
    return jax.tree.map(lambda x: x[np.resize(up, walkers)], states)


def numbers(tree):
    """(name, numbers) of each array; of keys, what they are made of."""
    for path, x in jax.tree.leaves_with_path(tree):
        key = jnp.issubdtype(x.dtype, jax.dtypes.prng_key)
        yield jax.tree_util.keystr(path), np.asarray(jax.random.key_data(x) if key else x)


@functools.cache
def tick(config):
    """The programs of one tick by native code and by XLA."""
    task = Task.of(config)
    ours = jax.jit(jax.vmap(lambda s: walk.scan(stepper.alone, task, 1, s)[0]))
    return ours, ticks.by_xla(task)


def ticked(config, states):
    """One tick of ``states`` by native code and by XLA, in programs of `ticks.WALKERS` each."""
    count = len(states.asked)
    parts = []
    for first in range(0, count, ticks.WALKERS):
        index = np.arange(first, first + ticks.WALKERS) % count
        part = jax.tree.map(lambda x, index=index: x[index], states)
        parts.append([program(part) for program in tick(config)])
    return (jax.tree.map(lambda *x: jnp.concatenate(x)[:count], *some) for some in zip(*parts, strict=True))


@pytest.mark.parametrize(
    "config",
    [PLANAR, *(pytest.param(x, marks=pytest.mark.slow) for x in (RIGID, WALLS))],
    ids=["planar", "rigid", "walls"],
)
def test_a_tick_is_xlas(config):
    states = walked(config)
    ours, theirs = ticked(config, states)
    far = []
    for (name, x), (_, y) in zip(numbers(ours), numbers(theirs), strict=True):
        if not np.issubdtype(x.dtype, np.floating):
            np.testing.assert_array_equal(x, y, err_msg=name)
            continue
        x, y = x.astype(np.float64), y.astype(np.float64)
        largest = max(1.0, np.abs(y[np.isfinite(y)]).max(initial=0.0))
        off = np.where(x == y, 0.0, np.abs(x - y)) / largest
        assert off.max() <= 1e-4, name
        far.append(off.ravel())
    assert np.median(np.concatenate(far)) < 1e-6


def test_a_number_that_is_not_finite_is_told_as_xla_does_or_matters_to_nobody():
    """Of one walker each: each number in turn, infinite or none."""
    state = jax.tree.map(lambda x: x[0], walked(PLANAR))
    places = [
        (i, at, value, f"{jax.tree_util.keystr(path)}{at} {value}")
        for i, (path, leaf) in enumerate(jax.tree.leaves_with_path(state))
        if jnp.issubdtype(leaf.dtype, jnp.floating)
        for at in np.ndindex(leaf.shape)
        for value in (np.nan, np.inf)
    ]
    names = [name for *_, name in places]
    leaves, tree = jax.tree.flatten(jax.tree.map(lambda x: jnp.repeat(x[None], len(places), axis=0), state))
    leaves = [np.array(x) if jnp.issubdtype(x.dtype, jnp.floating) else x for x in leaves]
    for row, (i, at, value, _) in enumerate(places):
        leaves[i][row, *at] = value
    states = jax.tree.unflatten(tree, leaves)
    ours, theirs = ticked(PLANAR, states)
    well = walk.scan(stepper.alone, Task.of(PLANAR), 1, state)[0]
    for k, name in enumerate(names):
        if bool(ours.broken[k]) == bool(theirs.broken[k]):
            continue
        assert bool(theirs.broken[k]), f"{name}: broken by native code alone"
        # What JAX multiplied by nought moves nothing, but stands where it stood.
        mine = jax.tree.map(lambda x, k=k: x[k], ours)
        for (where, x), (_, y) in zip(numbers(mine), numbers(well), strict=True):
            assert (x == y).all() or name.startswith(where), f"{name}: moves {where}"


def trial(task):
    """A pushed trial, and what it is held against."""
    keys, one = jax.random.split(jax.random.key(2), 1), np.ones(1, np.float32)
    scenario = jax.tree.map(lambda x: x[0], scenarios.batch(PLANAR, 40 * one, 0.5 * one, keys))
    profile = trials.Profile(jnp.ones(trials.BINS), jnp.float32(0.5))
    return trials.begin(task, PLANAR.gait, scenario), profile


WAYS = {
    "trials": lambda task: (trials._alone, task, *trial(task)),
    "rollout": lambda task: (rollout._alone, (rollout.watched(looked), task), trial(task)[0].state),
    "env": lambda task: (env._on, task, trial(task)[0].state.replace(asked=jnp.bool_(False))),
}


def looked(_, after):
    return after.walker.plant.qpos, after.walker.gait.stance


@pytest.mark.slow
@pytest.mark.parametrize("way", ["trials", "rollout", "env"])
def test_whatever_walks_goes_as_by_xla(way):
    """Fifty ticks, within which rounding cannot part them."""
    function, setting, state, *constants = WAYS[way](Task.of(PLANAR))

    def by_xla(state):
        return jax.lax.scan(lambda s, _: function(setting, s, *constants), state, length=50)

    ours = jax.jit(lambda s: walk.scan(function, setting, 50, s, *constants))(state)
    for (name, x), (_, y) in zip(numbers(ours), numbers(jax.jit(by_xla)(state)), strict=True):
        exact = not np.issubdtype(x.dtype, np.floating)
        np.testing.assert_allclose(
            x,
            y,
            atol=0 if exact else 2e-3 * max(1.0, np.abs(y[np.isfinite(y)]).max(initial=0)),
            rtol=0,
            err_msg=name,
        )


def test_noise_is_the_walkers_own():
    state = jax.tree.map(lambda x: x[0], walked(PLANAR)).walker
    found = walk.scan(_noise, None, 1, state)[1][0]
    np.testing.assert_allclose(found, walker.noise(state, 1)[0], rtol=1e-6, atol=1e-6)


def _noise(_, state):
    return state, walker.noise(state, 1)[0]


def test_the_environment_can_switch_native_code_off(monkeypatch):
    config = dataclasses.replace(PLANAR, kernels="off")
    assert backend.stepper_of(config) == "XLA"
    assert backend.stepper_of(PLANAR) == f"native code, {native.width()} walkers a vector"
    monkeypatch.setenv(engine.VARIABLE, "auto")
    assert not backend.native_here(Setup.of(config))
    monkeypatch.setenv(engine.VARIABLE, "off")
    assert not backend.native_here(Setup.of(PLANAR))
    monkeypatch.setattr(jax, "default_backend", lambda: "gpu")
    assert not engine.on_gpu(Setup.of(PLANAR))
    monkeypatch.setenv(engine.VARIABLE, "yes")
    with pytest.raises(UserError, match="JAXWALK_KERNELS='yes': give auto or off"):
        Setup.of(PLANAR)


@pytest.mark.parametrize("error", [Unsupported("a while loop"), compiler.BuildError("c++ failed")])
def test_where_no_native_code_can_be_made_xla_steps_and_it_is_said_once(monkeypatch, capsys, error):
    def fails(*_):
        raise error

    monkeypatch.setattr(walk, "scan", fails)
    monkeypatch.setattr(backend, "_failed", [])
    backend.say.cache_clear()
    for _ in range(2):
        told = backend.scan(Setup.of(PLANAR), _noise, None, 1, None, otherwise=lambda: (7, None))
        assert told == (7, None)
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and str(error) in said
    # What cannot be compiled is not tried again, and told of in results.
    assert ("c++ failed" in backend.stepper_of(PLANAR)) == isinstance(error, compiler.BuildError)


def test_mjx_itself_steps_whoever_asks_for_it():
    own, plain = PhysicsConfig(), PhysicsConfig(solver="mjx")
    config = dataclasses.replace(PLANAR, physics=plain)
    assert backend.stepper_of(config) == "mjx.step"
    assert not backend.native_here(Setup.of(config))
    ratio = Person.of(config.gait, jnp.float32(1.8), jnp.float32(75)).ratio

    def step(physics_config):
        model = physics.model_of(config.body, physics_config, ratio)
        plant = physics.Plant(jnp.zeros(9).at[1].set(1.2), jnp.zeros(9).at[3].set(1.0), jnp.zeros(9))
        told = jnp.zeros(6), jnp.zeros((7, 2))
        return jax.jit(partial(physics.step, config.body, physics_config))(model, plant, *told)[0]

    np.testing.assert_allclose(step(own).qvel, step(plain).qvel, atol=1e-5)


@pytest.mark.parametrize(
    "change, why",
    [
        (lambda spec: spec.worldbody.add_body().add_freejoint(), "neither slide nor turn"),
        (lambda spec: setattr(spec.joints[-1], "frictionloss", 1.0), "dry friction"),
        (lambda spec: setattr(spec.joints[-1], "stiffness", [1.0, 0, 0]), "springs"),
        (lambda spec: setattr(spec.option, "cone", 1), "elliptic"),
        (lambda spec: setattr(spec.option, "integrator", 0), "implicitfast"),
        (lambda spec: setattr(spec.option, "density", 1.2), "fluid"),
    ],
)
def test_a_model_that_the_own_solver_does_not_hold_is_refused_by_name(change, why):
    from jaxwalk.model import anthropometry, mjcf

    spec = mjcf.build(anthropometry.build(PLANAR.body), PLANAR.physics, "planar")
    dynamics.check(spec.compile())
    change(spec)
    for one in spec.bodies[1:]:
        if not one.mass and not one.geoms:
            one.mass, one.inertia = 1.0, [1.0, 1.0, 1.0]
    with pytest.raises(UserError, match=f"{why}.*--physics.solver mjx"):
        dynamics.check(spec.compile())
