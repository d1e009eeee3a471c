"""The page on which a walker is pushed, in a real browser: it walks as the package's own walkers do."""

import base64
import dataclasses
import json
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk import cli, deploy
from jaxwalk.export import command as export
from jaxwalk.kernels.graph import is_key
from jaxwalk.learn.policies import named
from jaxwalk.model import pushes
from jaxwalk.model.burdens import Burden
from jaxwalk.show import recording, scene, session
from jaxwalk.show.play import module, page, program
from jaxwalk.show.recording import Loop, Shove
from jaxwalk.show.web import document
from jaxwalk.task import backend, deployed, scenarios, stepper

READY = "new Promise(done => { const see = () => globalThis.jaxwalk ? done() : setTimeout(see, 10); see(); })"
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
MAPPED = """
(() => {
  const { PushMap, data, machines } = jaxwalk, controller = data.controllers[0], settings = { seed: 2 };
  for (const name in data.sliders) settings[name] = data.sliders[name].value;
  const map = new PushMap(machines[controller.module], controller, data);
  map.begin(settings); while (map.slice(1000));
  return map.cells;
})()
"""


@pytest.fixture(scope="module")
def shipped():
    return named.load("shipped")


@pytest.fixture(scope="module")
def file(shipped, tmp_path_factory):
    path = tmp_path_factory.mktemp("play") / "play.html"
    path.write_bytes(page.html(shipped, named.origin("shipped"), "jaxwalk play shipped"))
    return path


@pytest.fixture
def still(browser, file):
    """The page, paused."""
    one = browser(file)
    one.run(READY)
    one.run("document.getElementById('play').click()")
    return one


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


def _text(browser, name):
    return browser.run(f"document.getElementById('{name}').textContent")


@pytest.mark.parametrize("name", ["planned", pytest.param("told", marks=pytest.mark.slow)])
def test_modules_are_compiled_from_todays_source(name):
    kept = module.load(name)
    if kept.jax != jax.__version__:
        pytest.skip(f"made with jax {kept.jax}, which unrolls in its own order")
    config = named.load({"planned": "shipped", "told": "constant"}[name]).config
    assert program.digest(program.source(config)) == kept.source, "run: make page"
    given, state = json.loads(json.dumps(program.layouts(config)))
    assert (given, state) == (kept.given, kept.state) and program.kind(config) == kept.kind


def test_it_asks_for_nothing_and_is_small(still, file):
    assert still.requests == [file.as_uri()] and still.complaints == []
    assert document.read(file.read_bytes())[1] == () and file.stat().st_size < 600_000


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


def _lane(browser):
    return browser.run("(() => { const b = document.getElementById('scene').getBoundingClientRect(); "
                       "return [b.left + b.width / 2, b.top + b.height / 2]; })()")  # fmt: skip


def _drag(browser, by):
    x, y = _lane(browser)
    mouse = partial(browser.ask, "Input.dispatchMouseEvent", button="left", buttons=1, clickCount=1)
    mouse(type="mousePressed", x=x, y=y)
    mouse(type="mouseMoved", x=x + by, y=y)
    mouse(type="mouseReleased", x=x + by, y=y)


POSE = "[...jaxwalk.walkers()[0].pose]"
FRAMES = "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
ON = "for (let i = 0; i < {}; i++) document.getElementById('frame').click();"


def _settled(browser, windows=100):
    browser.run(ON.format(windows))
    browser.run(FRAMES)


@pytest.mark.parametrize("size", [(1280, 900), (390, 844)])
def test_a_whole_session(browser, file, size):
    """Pushed by key and by hand until it falls, begun anew, another stature, side by side, a map."""
    one = browser(file, *size)
    one.run(READY)
    one.run("document.getElementById('play').click()")
    _settled(one)
    one.press("ArrowRight")
    assert "Push +60 N s" in _text(one, "status")
    _settled(one)
    _drag(one, -120)
    (begun, ahead), (tick, back) = one.run("jaxwalk.session()")["events"]
    assert ahead == {"push": {"impulse": 60, "height": 0, "place": 0}}
    assert tick == begun + 1000 and -300 <= back["push"]["impulse"] < -20
    one.run("const size = document.getElementById('impulse'); size.value = 200;")
    for _ in range(3):
        one.press("ArrowRight")
        one.press("ArrowRight")
        _settled(one, 30)
    assert "Fell at" in _text(one, "status")
    one.press("r")
    assert one.run("jaxwalk.session()")["settings"]["seed"] == 1 and one.run("jaxwalk.walkers()[0].tick") == 0
    one.run("const stature = document.querySelector('#sliders input'); stature.value = 1.6")
    one.run("stature.dispatchEvent(new Event('input'))")
    assert one.run("jaxwalk.session()")["settings"]["height"] == 1.6
    one.run("[...document.querySelectorAll('#shown input')].slice(1).forEach((x) => x.click())")
    _settled(one, 50)
    assert one.run("jaxwalk.walkers().map((w) => [w.controller.name, w.done])") == [
        ["shipped", False], ["replan", False], ["constant", False],
    ]  # fmt: skip
    assert one.run("document.documentElement.scrollWidth <= innerWidth"), "nothing sticks out"
    assert one.complaints == []


def test_the_push_map_is_what_its_pushes_do(still):
    found = still.run(MAPPED)
    cells = np.array(found)
    assert cells.shape == (15, 16) and cells[5:9].all(), "up to 40 N s nobody falls"
    assert not cells[-1].all() and not cells[0].all() and 0.7 < cells.mean() < 1


def _link(told):
    text = json.dumps(told).encode()
    return base64.urlsafe_b64encode(text).decode().rstrip("=")


@pytest.fixture
def saved(still):
    _settled(still)
    still.press("ArrowRight")
    _settled(still, 40)
    still.run("document.getElementById('link').click()")
    return (
        still.run("jaxwalk.session()"),
        still.run("location.hash"),
        still.run(POSE),
    )


def test_a_link_walks_again(browser, file, saved):
    told, link, pose = saved
    one = browser(file)
    one.run(READY)
    one.run(f"location.hash = {json.dumps(link)}")
    one.run(FRAMES)
    one.run("document.getElementById('play').click()")
    one.run(f"while (jaxwalk.walkers()[0].tick < {told['ticks']}) document.getElementById('frame').click()")
    assert one.run(POSE) == pose and one.run("jaxwalk.session()") == told


def test_what_a_link_has_due_happens_before_what_comes_then(browser, file, saved):
    """And of what comes later nothing is left, once somebody does something else."""
    told, _, _ = saved
    (tick, push), last = told["events"][0], told["ticks"] // 10 * 10
    whole = told | {"events": [[tick, push], [last, {"slope": 1.0}]], "ticks": last}
    one = browser(file)
    one.run(READY)
    one.run("document.getElementById('play').click()")
    one.run(f"location.hash = '{_link(whole)}'")
    one.run(f"while (jaxwalk.walkers()[0].tick < {tick}) document.getElementById('frame').click()")
    one.run("const sheer = document.querySelectorAll('#sliders input')[5]; sheer.value = 0.8")
    one.run("sheer.dispatchEvent(new Event('input'))")
    assert one.run("jaxwalk.session()")["events"] == [[tick, push], [tick, {"friction": 0.8}]]
    assert one.run("jaxwalk.walkers()[0].whole('walker.push.start')") == tick


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (None, "cut off"),
        ({"format": 7}, "not one of this kind"),
        ({"policy": {"name": "other", "digest": "0"}}, "another policy"),
        ({"settings": {"height": 9.0}}, "height of 9: 1.4 to 2.3 m"),
        ({"events": [[7, {}]]}, "out of order"),
        ({"events": [[10, {"push": {"impulse": 9000}}]]}, "within 300 N s"),
        ({"ticks": 10**9}, "longer than"),
        ({"events": [[10, {"toString": 1}]]}, "unknown: toString"),
        ({"events": [[10, {"push": {"impulse": 60, "height": True}}]]}, "push that is none"),
        ({"settings": {"speed": "1"}}, "give a number"),
        ({"settings": {"delay": 0.1}}, "delay of 100: 0 to 40 ms"),
        ({"shown": ["nobody"]}, "who is not here"),
    ],
)
def test_a_bad_link_is_told_in_one_line_and_the_walker_stays(still, saved, change, says):
    told, link, _ = saved
    text = link[1:-7]
    if change is not None:
        whole = told | change
        text = _link(whole | {"settings": told["settings"] | whole["settings"]})
    still.run(f"location.hash = '{text}'")
    still.run(FRAMES)
    assert says in _text(still, "notice") and "\n" not in _text(still, "notice")
    _settled(still, 5)
    assert still.run("jaxwalk.walkers()[0].tick") > 0 and still.complaints == []


def test_what_a_page_saves_is_walked_again(shipped, saved, tmp_path):
    told, _, pose = saved
    path = tmp_path / "push.json"
    path.write_text(json.dumps(told))
    found = session.read(path)
    walk = session.record(session.subject("shipped", path), found, scene.model(shipped.config))
    (tick, _), = told["events"]  # fmt: skip
    assert [(x.impulse, x.time) for x in walk.pushes] == [(60.0, pytest.approx(tick * 0.002))]
    np.testing.assert_allclose(walk.qpos[-1], pose, atol=1e-3)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("{", "not JSON"),
        ("{}", "format 1"),
        ('{"format": 1, "settings": 3}', "settings"),
        ('{"format": 1, "settings": {}}', "seed"),
        (None, "No such file"),
    ],
)
def test_a_file_that_is_no_session(tmp_path, capsys, text, says):
    path = tmp_path / "push.json"
    if text is not None:
        path.write_text(text)
    code = cli.main(["render", "shipped", "--session", str(path), "--out", str(tmp_path / "x.png")])
    told = capsys.readouterr().err
    assert code == 2 and says in told and told.count("\n") == 1 and not (tmp_path / "x.png").exists()


@pytest.mark.parametrize(
    ("policy", "says"), [("raibert", "no such rule"), ("shipped-rigid", "a page walks with")]
)
def test_who_has_no_page(tmp_path, capsys, policy, says):
    out = tmp_path / "x.html"
    assert cli.main(["play", policy, "--out", str(out), "--no-open"]) == 2
    assert says in capsys.readouterr().err and not out.exists()


def test_without_webassembly_it_says_so(browser, file):
    one = browser(file)
    told = one.ask("Page.addScriptToEvaluateOnNewDocument", source="delete globalThis.WebAssembly")
    one.show(file)
    one.ask("Page.removeScriptToEvaluateOnNewDocument", identifier=told["identifier"])
    assert "no WebAssembly" in _text(one, "notice") and one.complaints == []
