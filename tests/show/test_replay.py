"""The page that replays walks, in a real browser: it shows what was recorded, and runs nothing else."""

import json
from dataclasses import replace
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest

from jaxwalk import cli
from jaxwalk.common.errors import UserError
from jaxwalk.learn.policies import named as subjects
from jaxwalk.learn.policies import policy
from jaxwalk.show.replay_page import data, replay
from jaxwalk.show.web import document

IMPULSES = (-40.0, 120.0)  # the second one is lost
SCRUB = """
(t => {{ const s = document.getElementById("scrub"); s.value = t; s.dispatchEvent(new Event("input")); }})({})
"""
PIXELS = """
(points => {{
  const c = document.getElementById("scene"), pen = c.getContext("2d");
  return points.map(([x, y]) => [...pen.getImageData(Math.round(x), Math.round(y), 1, 1).data.slice(0, 3)]);
}})({})
"""
FOUND = """
(([r, g, b]) => {{
  const c = document.getElementById("scene"), {{ width, height }} = c;
  const all = c.getContext("2d").getImageData(0, 0, width, height).data;
  let n = 0, x = 0, y = 0;
  for (let i = 0; i < all.length; i += 4) {{
    if (all[i] !== r || all[i + 1] !== g || all[i + 2] !== b) continue;
    n++; x += i / 4 % width; y += Math.floor(i / 4 / width);
  }}
  return [n, x / n + 0.5, y / n + 0.5];
}})({})
"""
LATER = """
new Promise(done => {
  const scene = document.getElementById("scene");
  const see = () => scene.dataset.time > 0.05 ? done() : requestAnimationFrame(see);
  see();
})
"""
TWO_FRAMES = "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"


@pytest.fixture(scope="module")
def recorded():
    return replay.record(subjects.load("fixed"), IMPULSES, 0)


@pytest.fixture(scope="module")
def file(recorded, tmp_path_factory):
    path = tmp_path_factory.mktemp("replay") / replay.FILE
    path.write_bytes(replay.html(recorded, None, "jaxwalk export fixed"))
    return path


@pytest.fixture
def still(browser, file):
    """The page, which does not play by itself."""
    return browser(file, prefers_reduced_motion="reduce")


def _colour(browser, name):
    text = browser.run(f"getComputedStyle(document.documentElement).getPropertyValue('--{name}').trim()")
    return [int(text[i : i + 2], 16) for i in (1, 3, 5)]


def _text(browser, name):
    return browser.run(f"document.getElementById('{name}').textContent")


def _time(browser):
    return float(browser.run("document.getElementById('scene').dataset.time"))


def _go(browser, walk, time):
    browser.press(str(walk + 1))
    browser.run(SCRUB.format(time))
    assert _time(browser) == pytest.approx(time)


def test_the_page_is_small_and_asks_for_nothing(still, file):
    assert file.stat().st_size < 1_000_000
    assert still.requests == [file.as_uri()] and still.complaints == []


def _pixels(browser, recorded, walk, time):
    """Gives where on the canvas a geom of the model is by C MuJoCo, (x, y), at that moment of that walk."""
    told = {k: float(v) for k, v in browser.run("({...document.getElementById('scene').dataset})").items()}
    one, state = recorded.walks[walk], mujoco.MjData(recorded.model)
    state.qpos[:] = one.qpos[round(time / one.timestep)]
    mujoco.mj_forward(recorded.model, state)

    def pixel(name):
        x, _, z = state.geom(name).xpos
        return [float((x - told["left"]) * told["scale"]), float(told["ground"] - z * told["scale"])]

    return pixel


@pytest.mark.parametrize(("walk", "time"), [(0, 0.0), (0, 6.2), (1, 3.05), (2, 3.3), (2, 4.4)])
def test_the_pose_drawn_is_the_recorded_one(still, recorded, walk, time):
    """By C MuJoCo's own kinematics, against the pixels."""
    _go(still, walk, time)
    pixel = _pixels(still, recorded, walk, time)
    colours = {name: _colour(still, name) for name in ("near", "far", "head")}
    near = [pixel(f"{part}_right") for part in ("thigh", "shank", "foot")]
    np.testing.assert_allclose(still.run(PIXELS.format(json.dumps(near))), [colours["near"]] * 3, atol=8)
    far = still.run(PIXELS.format(json.dumps([pixel(f"{part}_left") for part in ("thigh", "shank", "foot")])))
    legs = [
        min(np.abs(np.subtract(one, colours[name])).max() for name in ("far", "near")) <= 8 for one in far
    ]
    assert sum(legs) >= 2, "behind the other leg, one of them perhaps at its rim"
    count, *middle = still.run(FOUND.format(colours["head"]))
    assert count > 50
    np.testing.assert_allclose(middle, pixel("head"), atol=1.0)


def test_between_poses_it_moves_on_a_straight_line(still, recorded):
    one, lefts = recorded.walks[0], []
    for time in (5.0, 5.005, 5.01):
        _go(still, 0, 5.0)
        still.run(f"document.getElementById('scrub').step = 0.001; {SCRUB.format(time)}")
        lefts.append(float(still.run("document.getElementById('scene').dataset.left")))
    assert lefts[2] > lefts[0] and one.timestep <= 0.005
    assert lefts[1] == pytest.approx((lefts[0] + lefts[2]) / 2, abs=1e-5)


def test_the_push_shows_at_its_time_with_its_impulse(still):
    red = _colour(still, "push")

    def reds(walk, time):
        _go(still, walk, time)
        return still.run(FOUND.format(red))[0], _text(still, "status")

    assert reds(0, 3.05) == (0, "walking") and reds(1, 2.99) == (0, "walking")
    count, said = reds(1, 3.05)
    assert count > 300 and said == "push −40 N s"
    assert 0 < reds(1, 5.0)[0] < 100, "the floor keeps the mark"


def test_touch_downs_are_marked_and_a_fall_is_told(still, recorded):
    landed = next(f.time for f in recorded.walks[0].footfalls if f.leg == 1)
    right = []
    for time in (landed - 0.02, landed + 0.02):
        _go(still, 0, round(time, 2))
        pixel = _pixels(still, recorded, 0, landed)
        below = [(pixel("heel_right")[0] + pixel("toe_right")[0]) / 2, pixel("toe_right")[1] + 10]
        (seen,) = still.run(PIXELS.format(json.dumps([below])))
        right.append(np.abs(np.subtract(seen, _colour(still, "near"))).max() <= 8)
    assert right == [False, True]
    fell = recorded.walks[2].fell
    _go(still, 2, round(fell + 0.5, 2))
    assert _text(still, "status") == f"fell at {fell:.2f} s"


def test_playing_goes_on_until_it_is_paused(still):
    still.run("document.getElementById('play').click()")
    still.run(LATER)
    assert _text(still, "play-word") == "Pause"
    still.run("document.activeElement.blur()")
    still.press(" ")
    paused = _time(still)
    still.run(TWO_FRAMES)
    assert _time(still) == paused and _text(still, "play-word") == "Play"


def test_it_plays_by_itself_only_where_motion_is_welcome(browser, file):
    page = browser(file, prefers_reduced_motion="reduce")
    page.run(TWO_FRAMES)
    assert (_time(page), _text(page, "play-word")) == (0, "Play")
    page = browser(file, prefers_reduced_motion="no-preference")
    page.run(LATER)
    assert _text(page, "play-word") == "Pause"


def test_keys_and_chart_go_to_a_time_a_speed_and_a_walk(still):
    for key in ("ArrowRight", "ArrowRight", "ArrowLeft", "."):
        still.press(key)
    assert _time(still) == pytest.approx(0.11)
    still.press("ArrowDown")
    assert still.run("document.getElementById('rate').value") == "0.5"
    still.press("3")
    assert still.run("document.querySelector('#walks input:checked').value") == "2"
    still.run("document.querySelectorAll('#walks input')[0].click()")
    assert still.run("document.querySelector('#walks input:checked').value") == "0"
    left, top, wide = still.run(
        "(b => [b.left, b.top, b.width])(document.getElementById('chart').getBoundingClientRect())"
    )
    still.click(left + wide / 2, top + 40)
    middle = _time(still)
    still.click(left + wide / 4, top + 40)
    assert 4.5 < middle < 5.5 and 2.0 < _time(still) < 2.6
    still.press("End")
    assert _time(still) == pytest.approx(10.0)
    assert still.complaints == []


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_it_fits_a_phone_in_light_and_dark(browser, file, theme):
    phone = browser(file, 390, 844, prefers_color_scheme=theme)
    assert phone.run("document.documentElement.scrollWidth") <= 390
    ink, back = (sum(_colour(phone, name)) for name in ("ink", "back"))
    assert (ink < back) == (theme == "light")
    assert phone.run("getComputedStyle(document.body).color") != phone.run(
        "getComputedStyle(document.body).backgroundColor"
    )
    assert phone.complaints == []


def test_every_control_has_a_name(still):
    nodes = still.ask("Accessibility.getFullAXTree")["nodes"]
    roles = {"button", "slider", "radio", "combobox", "image", "status"}
    named = [(n["role"]["value"], n["name"]["value"]) for n in nodes if not n["ignored"] and "name" in n]
    assert {"button", "slider", "radio", "combobox", "image"} <= {role for role, _ in named}
    assert all(name for role, name in named if role in roles - {"status"})


NASTY = "</script><img src=http://localhost:9/x onerror=\"document.title='broken out'\"><!-- & {{ 7 * 7 }}"


def test_what_a_policy_says_of_itself_is_text(browser, recorded, tmp_path):
    origin = policy.load(subjects.file("shipped")).metadata
    told = replace(recorded, subject=replace(recorded.subject, name=NASTY))
    path = tmp_path / replay.FILE
    path.write_bytes(replay.html(told, replace(origin, command=NASTY, jaxwalk_version=NASTY), NASTY))
    shown = browser(path)
    assert shown.run("document.body.innerText").count(NASTY) == 5
    assert shown.run("document.title") == f"{NASTY}: jaxwalk replay"
    assert shown.run("document.images.length") == 0
    assert shown.requests == [path.as_uri()] and shown.complaints == []
    assert _text(shown, "status"), "its script has run"


def test_data_end_no_script_and_read_back():
    content = {"walks": [NASTY, "\u2028", "a, b: c"], "n": -1.5}
    html = document.render(document.Document("jaxwalk.show.replay_page", ("page.js",), "p", "l", (), content))
    assert document.read(html) == (content, ())


def test_a_page_that_shows_something_else_fails_its_test(recorded, file, tmp_path):
    assert replay.verify(file, recorded) <= 0.51 * data.UNIT
    path, good = tmp_path / "page.html", file.read_bytes()
    first = json.dumps(document.read(good)[0]["walks"][0]["columns"]["z"][:3], separators=(",", ":"))[
        :-1
    ].encode()
    assert good.count(first)
    for bad, says in (
        (good.replace(first, first[:-1] + b"%d" % ((first[-1] - 45) % 10), 1), "a pose differs"),
        (good[: len(good) // 2], "cannot be read back"),
        (good.replace(b"<main>", b'<main><img src="//elsewhere/x.png">'), "would load //elsewhere"),
        (b"\xff", "cannot be read back"),
    ):
        path.write_bytes(bad)
        with pytest.raises(UserError, match=says):
            replay.verify(path, recorded)


@pytest.mark.parametrize("old", [False, True], ids=["render", "export --format html"])
def test_the_command_writes_the_page_and_tests_it(recorded, tmp_path, monkeypatch, capsys, old):
    asked = []
    monkeypatch.setattr(replay, "record", lambda *args: asked.append(args) or recorded)
    made = ["export", "fixed", "--format", "html", "--out", str(tmp_path), "--verify", "True"]
    made = made if old else ["render", "fixed", "--out", str(tmp_path / replay.FILE)]
    assert cli.main([*made, "--impulses", "-40,120", "--seed", "3"]) == 0
    assert asked[0][1:3] == (IMPULSES, 3)
    found, _ = document.read((tmp_path / replay.FILE).read_bytes())
    assert [one["push"] and one["push"]["impulse"] for one in found["walks"]] == [None, *IMPULSES]
    out, error = capsys.readouterr()
    assert "3 walks" in out and ("jaxwalk render fixed --out" in error) == old
    assert [path.name for path in tmp_path.iterdir()] == [replay.FILE]


BAD = {
    "rule, other format": (["--format", "html,npz"], "a rule, not trained"),
    "no impulse": (["--format", "html", "--impulses", "0"], "--impulses 0: give -1000 to 1000 N s"),
    "too strong": (["--format", "html", "--impulses", "40,1001"], "--impulses 1001: give"),
    "twice": (["--format", "html", "--impulses", "40,40"], "each impulse once"),
    "many": (["--format", "html", "--impulses", ",".join(map(str, range(1, 14)))], "12 at most"),
    "for another format": (["--format", "npz", "--impulses", "40"], "Unrecognized options: --impulses"),
    "seed": (["--format", "html", "--seed", "-1"], "--seed -1: give a whole number"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line_and_writes_nothing(case, tmp_path, capsys, monkeypatch):
    argv, says = BAD[case]
    monkeypatch.setattr(replay, "record", lambda *_: SimpleNamespace())
    assert cli.main(["export", "fixed", "--out", str(tmp_path / "out"), *argv]) == 2
    said = capsys.readouterr().err
    assert says in said and said.count("\n") == 1
    assert list(tmp_path.iterdir()) == []
