"""The viewer without a screen: keys to pushes, the walker under them, and its refusals."""

from dataclasses import replace

import numpy as np
import pytest

from jaxwalk import cli
from jaxwalk.learn.policies import named
from jaxwalk.show import recording, scene
from jaxwalk.show.recording import Loop, Shove
from jaxwalk.show.scene import Arrow
from jaxwalk.show.viewer import command, keys
from jaxwalk.show.viewer.keys import Wishes
from jaxwalk.show.viewer.session import Session


def _typed(*pressed):
    wishes = Wishes()
    for key in pressed:
        wishes = keys.pressed(wishes, key)
    return wishes


def test_arrows_push_by_the_impulse_that_was_set():
    assert _typed(keys.RIGHT).push == 40.0 and _typed(keys.LEFT).push == -40.0
    assert _typed(keys.UP, keys.UP, keys.DOWN, keys.UP, keys.LEFT).push == -60.0
    assert _typed(keys.LEFT, keys.RIGHT).push == 40.0, "the last one counts"
    assert _typed(*[keys.DOWN] * 30, keys.RIGHT).push == keys.LEAST > 0
    assert _typed(*[keys.UP] * 30, keys.LEFT).push == -keys.MOST


def test_space_pauses_and_r_restarts():
    assert _typed(keys.SPACE).paused and not _typed(keys.SPACE, keys.SPACE).paused
    asked = _typed(keys.SPACE, keys.RESTART)
    assert asked.restart and not asked.paused
    assert _typed(ord("Q"), 341, 0) == Wishes()
    assert keys.granted(_typed(keys.UP, keys.RIGHT, keys.RESTART)) == Wishes(impulse=50.0)


@pytest.mark.parametrize(
    ("now", "windows", "due"),
    [(4.99, 1, 5.02), (5.0, 1, 5.02), (5.03, 2, 5.04), (5.19, 10, 5.2), (9.0, command.CATCH_UP, 9.02)],
)
def test_late_pictures_are_made_up_for_by_more_windows_within_limits(now, windows, due):
    assert command.due_windows(now, 5.0, 0.02) == (windows, pytest.approx(due))


@pytest.fixture(scope="module")
def loop():
    return Loop(named.load("replan"), recording.SEGMENT)  # the program that films and pages use


@pytest.fixture(scope="module")
def model():
    return scene.model(named.load("replan").config)


def test_a_push_by_key_is_the_push_of_a_recorded_walk(loop, model):
    session, window = Session(loop, model, 0), loop.ticks
    assert session.advance(Wishes(impulse=60.0)) == Wishes(impulse=60.0)
    assert session.arrow is None
    assert session.advance(Wishes(push=-40.0)) == Wishes(), "made, and not again"
    walk = recording.record(loop, model, 3 * session.window, 0, Shove(-40.0, session.window))
    np.testing.assert_array_equal(session.data.qpos, walk.qpos[2 * window].astype(float))
    assert session.speed == walk.speed[2 * window] and session.seconds == 2 * session.window
    session.advance(Wishes())
    np.testing.assert_array_equal(session.data.qpos, walk.qpos[3 * window].astype(float))


def test_an_arrow_shows_while_the_push_acts_and_fades():
    pushed = Shove(-40.0, 2.0)

    def strength(second, push: Shove | None = pushed):
        arrow = Arrow.at(push, second)
        return 0.0 if arrow is None else arrow.strength

    assert strength(2.05, None) == strength(1.99) == strength(3.0) == 0
    assert strength(2.0) == strength(2.0999) == 1 and 0 < strength(2.3) < strength(2.2) < 1


def test_paused_nothing_moves_and_the_push_waits(loop, model):
    session = Session(loop, model, 0)
    before, wishes = session.data.qpos.copy(), Wishes(paused=True, push=40.0)
    assert session.advance(wishes) == wishes
    np.testing.assert_array_equal(session.data.qpos, before)
    session.advance(replace(wishes, paused=False))
    assert session.push == Shove(40.0, 0.0)


def test_one_who_falls_lies_down_and_starts_anew(loop, model):
    session = Session(loop, model, 7)
    first = session.data.qpos.copy()
    session.advance(Wishes(push=200.0))
    while session.fell is None and session.seconds < 4:
        session.advance(Wishes())
    assert session.fell is not None and 0 < session.fell <= session.seconds
    for _ in range(3):
        session.advance(Wishes(push=50.0))
    assert session.data.qpos[1] < 0.5, "the hip is still up"
    assert session.push == Shove(200.0, 0.0), "who lies is not pushed"
    session.advance(Wishes(restart=True))
    assert (session.fell, session.push, session.starts) == (None, None, 2)
    assert session.seconds == session.window
    other = Session(loop, model, 8)
    assert not np.array_equal(other.data.qpos, first), "each start is another one"
    other.advance(Wishes())
    np.testing.assert_array_equal(other.data.qpos, session.data.qpos)


def test_without_a_screen_it_is_one_line_and_2(monkeypatch, capsys):
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert cli.main(["view", "fixed"]) == 2
    said = capsys.readouterr().err
    assert said.startswith("jaxwalk: error: no screen") and said.count("\n") == 1
    assert "--out walk.html" in said
