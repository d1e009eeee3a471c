"""A page's walkers walk as the package's own do: by the native tick, and by NumPy on C MuJoCo."""

import dataclasses
import json
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk import deploy
from jaxwalk.export import command as export
from jaxwalk.kernels.graph import is_key
from jaxwalk.learn.policies import named
from jaxwalk.model import pushes
from jaxwalk.model.burdens import Burden
from jaxwalk.show import recording
from jaxwalk.show.play import module, program
from jaxwalk.show.recording import Loop, Shove
from jaxwalk.task import backend, deployed, scenarios, stepper

WALKED = """
(({{ name, state, windows, push, at }}) => {{
  const {{ Walker, data, machines }} = jaxwalk, controller = data.controllers.find((c) => c.name === name);
  const walker = new Walker(machines[controller.module], controller, data);
  walker.restore(Uint32Array.from(state));
  const poses = [[...walker.pose]];
  if (push) walker.push({{ impulse: push }}, at);
  for (let i = 0; i < windows; i++) {{ walker.window(); poses.push([...walker.pose]); }}
  return {{ poses, done: walker.done, on: walker.walksOn }};
}})({})
"""
MANY = """
((drawn) => {{
  const {{ Walker, data, machines }} = jaxwalk, controller = data.controllers[0];
  const walker = new Walker(machines[controller.module], controller, data);
  return drawn.map((state) => {{
    walker.restore(Uint32Array.from(state));
    for (let i = 0; i < {windows}; i++) walker.window();
    return walker.done;
  }});
}})({drawn})
"""
STARTED = """
(() => {
  const { Walker, data, machines } = jaxwalk, controller = data.controllers[0], settings = { seed: 3 };
  for (const name in data.sliders) settings[name] = data.sliders[name].value;
  const walker = new Walker(machines[controller.module], controller, data);
  walker.start(settings);
  return [...walker.kept()];
})()
"""


def _words_of(leaf):
    whole = np.asarray(jax.random.key_data(leaf) if is_key(leaf.dtype) else leaf)
    return (whole.astype(np.int32) if whole.dtype == bool else whole).ravel().view(np.uint32)


def _words(state):
    """A walker's state as a page keeps it."""
    return np.concatenate([_words_of(leaf) for leaf in jax.tree.leaves(state)])


def _unburdened(friction=0.9):
    none = dict.fromkeys(("mass", "ahead", "up", "force", "slope", "delay"), jnp.float32(0))
    return Burden(friction=jnp.float32(friction), strength=jnp.float32(1), **none)


def _walked(browser, name, state, windows=500, push=0.0, at=0):
    told = dict(name=name, state=_words(state).tolist(), windows=windows, push=push, at=at)
    return browser.run(WALKED.format(json.dumps(told)))


@pytest.mark.parametrize("name", ["planned", pytest.param("told", marks=pytest.mark.slow)])
def test_modules_are_compiled_from_todays_source(name):
    kept = module.load(name)
    if kept.jax != jax.__version__:
        pytest.skip(f"made with jax {kept.jax}, which unrolls in its own order")
    config = named.load({"planned": "shipped", "told": "constant"}[name]).config
    assert program.digest(program.source(config)) == kept.source, "run: make page"
    given, state = json.loads(json.dumps(program.layouts(config)))
    assert (given, state) == (kept.given, kept.state) and program.kind(config) == kept.kind


def test_it_starts_as_natively(still, shipped):
    found = still.run(STARTED)
    state = Loop(shipped, 1).start(3, _unburdened())
    for (at, shape, kind), leaf in zip(
        module.load("planned").state.values(), jax.tree.leaves(state), strict=True
    ):
        told = np.array(found[at : at + int(np.prod(shape, dtype=int))], np.uint32)
        wanted = _words_of(leaf)
        if kind == "F":
            told, wanted = told.view(np.float32), wanted.view(np.float32)
        np.testing.assert_allclose(told, wanted, atol=1e-6, rtol=1e-5)


@pytest.mark.parametrize("name", ["shipped", "replan", "constant"])
def test_the_walk_is_the_native_one(still, name):
    """10 s, pushed after three: the same poses, but for rounding; by that a foot may land a tick sooner or
    later, in which a joint turns by up to 0.03 rad.

    From the second second on: at a start the soles are at the floor, and whether they touch it is rounding.
    """
    loop = Loop(named.load(name), recording.SEGMENT)
    begun, _ = loop.advance(loop.start(3, _unburdened()))
    state = loop.pushed(begun, Shove(-60.0, 3.0))
    poses: list[np.ndarray] = [np.asarray(state.walker.plant.qpos)[None]]
    for _ in range(10):
        state, rows = loop.advance(state)
        poses.append(np.asarray(rows.qpos[9::10]))
    found = _walked(still, name, begun, push=-60.0, at=1500)
    apart = np.abs(np.concatenate(poses) - found["poses"]).max(axis=1)
    assert not found["done"] and found["on"] and found["poses"][-1][0] > 8
    assert apart[:51].max() < 1e-4 and apart.max() < 0.05


def test_200_drawn_pushes_are_survived_as_natively(still, shipped):
    """One by one, whoever is pushed: of other bodies, and burdened, too. Where they differ, rounding decides:
    of copies whose numbers differ natively in the sixth digit, some fall and some do not."""
    count, windows, rng = 200, 250, np.random.default_rng(5)
    drawn = dict(
        seed=np.arange(count),
        height=rng.uniform(1.5, 2.0, count),
        speed=rng.uniform(0.7, 1.3, count),
        noise=rng.uniform(0.0, 2.0, count),
        slope=np.where(np.arange(count) % 4 == 1, rng.uniform(-3, 3, count), 0.0),
        friction=np.where(np.arange(count) % 4 == 2, rng.uniform(0.4, 1.2, count), 0.9),
        delay=np.where(np.arange(count) % 4 == 3, 0.02, 0.0),
        strength=np.where(np.arange(count) % 8 == 7, 0.8, 1.0),
    )
    drawn["mass"] = 75 * (drawn["height"] / 1.8) ** 3
    impulses, ats = rng.uniform(60, 200, count) * rng.choice([-1, 1], count), rng.integers(1000, 1400, count)
    task = program.task_of(shipped.config)

    def begin(own, impulse, at):
        burden = _unburdened().replace(
            slope=jnp.deg2rad(own["slope"]), **{name: own[name] for name in ("friction", "strength", "delay")}
        )
        numbers = dataclasses.replace(shipped.config.gait, speed_desired=own["speed"])
        key = scenarios.root(own["seed"], scenarios.RECORDED)
        state = stepper.start(task, numbers, own["height"], own["mass"], own["noise"], key, burden)
        push = pushes.of_impulse(impulse, at, 0.1, 0.002, jnp.float32(0))
        return state.replace(walker=state.walker.replace(push=push))

    def walk(windows, state):
        def window(state, _):
            state = stepper.decide(state, shipped.act(shipped.params, state.observation))

            def by_xla():
                return jax.lax.scan(lambda one, _: stepper.alone(task, one), state, length=10)

            return backend.scan(task.setup, stepper.alone, task, 10, state, otherwise=by_xla)[0], None

        return jax.lax.scan(window, state, length=windows)[0]

    given = {k: jnp.asarray(v, jnp.uint32 if k == "seed" else jnp.float32) for k, v in drawn.items()}
    states = jax.jit(jax.vmap(begin))(given, jnp.asarray(impulses, jnp.float32), jnp.asarray(ats, jnp.int32))
    states = jax.jit(jax.vmap(partial(walk, 50)))(states)
    on = jax.jit(jax.vmap(partial(walk, windows)))
    fell = np.asarray(on(states).terminated)
    told = [_words(jax.tree.map(lambda x, i=i: x[i], states)).tolist() for i in range(count)]
    found = still.run(MANY.format(windows=windows, drawn=json.dumps(told)))
    assert 0.1 < np.mean(fell) < 0.9, "or nothing is told apart"
    unlike = np.flatnonzero(np.array(found) != fell)
    assert len(unlike) <= 0.01 * count
    for walker in unlike:
        copies = jax.tree.map(lambda x, i=walker: jnp.broadcast_to(x[i], (count, *x.shape[1:])), states)
        plant = copies.walker.plant
        moved = {
            k: getattr(plant, k) * (1 + 1e-5 * rng.standard_normal((count, 9))) for k in ("qpos", "qvel")
        }
        plant = plant.replace(**{k: jnp.asarray(v, jnp.float32) for k, v in moved.items()})
        copies = copies.replace(walker=copies.walker.replace(plant=plant))
        assert len(set(np.asarray(on(copies).terminated).tolist())) == 2, walker


def test_the_walk_is_that_of_the_exported_controller_on_c_mujoco(still, shipped, tmp_path, monkeypatch):
    """In NumPy, by another solver run to its end, without noise."""
    monkeypatch.setattr(scenarios, "DEPLOYED", scenarios.RECORDED)  # the same start
    quiet = named.load("shipped", noise=0.0)
    controller = deploy.Controller.load(export.write(*export.load("shipped"), ("npz",), tmp_path)["npz"])
    walk = deployed.walk(quiet.config, controller, 10.0, 1, keep=True)
    found = _walked(still, "shipped", Loop(quiet, 1).start(1, _unburdened()))
    apart = np.abs(np.stack(walk.qpos)[::10] - found["poses"])
    assert not walk.fell and not found["done"]
    assert apart[:, :3].max() < 0.01, "of ten metres"
    # A foot that lands a few ticks sooner or later: a swinging shank turns by 0.02 rad in one.
    assert np.median(apart[:, 3:]) < 0.005 and apart[:, 3:].max() < 0.15
