"""The page on which a walker is pushed, as its reader uses it."""

import base64
import json
from functools import partial

import numpy as np
import pytest

from jaxwalk import cli
from jaxwalk.show import scene, session
from jaxwalk.show.web import document

MAPPED = """
(() => {
  const { PushMap, data, machines } = jaxwalk, controller = data.controllers[0], settings = { seed: 2 };
  for (const name in data.sliders) settings[name] = data.sliders[name].value;
  const map = new PushMap(machines[controller.module], controller, data);
  map.begin(settings); while (map.slice(1000));
  return map.cells;
})()
"""


def _text(browser, name):
    return browser.run(f"document.getElementById('{name}').textContent")


def test_it_asks_for_nothing_and_is_small(still, file):
    assert still.requests == [file.as_uri()] and still.complaints == []
    assert document.read(file.read_bytes())[1] == () and file.stat().st_size < 600_000


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
def test_a_whole_session(paused, size):
    """Pushed by key and by hand until it falls, begun anew, another stature, side by side, a map."""
    one = paused(*size)
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


def test_a_link_walks_again(paused, saved):
    told, link, pose = saved
    one = paused()
    one.run(f"location.hash = {json.dumps(link)}")
    one.run(f"while (jaxwalk.walkers()[0].tick < {told['ticks']}) document.getElementById('frame').click()")
    assert one.run(POSE) == pose and one.run("jaxwalk.session()") == told


def test_what_a_link_has_due_happens_before_what_comes_then(paused, saved):
    """And of what comes later nothing is left, once somebody does something else."""
    told, _, _ = saved
    (tick, push), last = told["events"][0], told["ticks"] // 10 * 10
    whole = told | {"events": [[tick, push], [last, {"slope": 1.0}]], "ticks": last}
    one = paused()
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
