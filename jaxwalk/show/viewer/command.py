"""``jaxwalk view``: a policy in MuJoCo's viewer, in real time, with a push at a key."""

from __future__ import annotations

import importlib
import queue
import subprocess
import sys
import time
from typing import TYPE_CHECKING, Any

import mujoco
from rich.console import Console

from jaxwalk.common.errors import UserError
from jaxwalk.config import REFERENCE_HEIGHT
from jaxwalk.learn.policies import named
from jaxwalk.show import scene
from jaxwalk.show.recording import Loop
from jaxwalk.show.viewer import keys
from jaxwalk.show.viewer.keys import Wishes
from jaxwalk.show.viewer.session import Session

if TYPE_CHECKING:
    from jaxwalk.show.viewer.options import ViewArgs

CATCH_UP = 10  # windows between two pictures, at most; time lost beyond them is given up
SHADOW = 1024  # pixels of a shadow map: a quarter of a film's, drawn fifty times a second
_PACE_SECONDS = 2.0  # over which the pace that is shown is averaged

# MuJoCo's viewer waits for ever for a window that cannot be opened: it is tried in a process of its own.
_PROBE = """
import sys, glfw
glfw.init() or sys.exit(1)
glfw.window_hint(glfw.VISIBLE, glfw.FALSE)
sys.exit(0 if glfw.create_window(64, 64, "", None, None) else 1)
"""


def require_screen() -> None:
    """See that a window could be opened.

    Raises:
      UserError: there is no screen to open a window with OpenGL on.
    """
    if subprocess.run([sys.executable, "-c", _PROBE], capture_output=True).returncode:
        raise UserError(
            "no screen that a window with OpenGL opens on: give a desktop session (DISPLAY), or watch "
            "a page by jaxwalk render POLICY --out walk.html, or a film"
        )


def main(args: ViewArgs) -> None:
    """Run ``jaxwalk view``, until the window is closed.

    Raises:
      UserError: no such policy, or no screen.
    """
    subject = named.asked(args)
    require_screen()
    console = Console(markup=False)
    model, stature = scene.model(subject.config), subject.config.body.height
    model.vis.quality.shadowsize = SHADOW
    with console.status("compiling"):
        session = Session(Loop(subject, 1), model, args.seed)
        session.advance(Wishes())
    for key, what in keys.HELP:
        console.print(f"  {key:<12} {what}", highlight=False)
    pressed: queue.SimpleQueue[int] = queue.SimpleQueue()
    try:
        viewer = importlib.import_module("mujoco.viewer").launch_passive(
            model, session.data, key_callback=pressed.put, show_left_ui=False, show_right_ui=False
        )
    except RuntimeError as error:  # macOS without mjpython
        raise UserError(f"MuJoCo's viewer does not start here: {error}") from None
    with viewer:
        with viewer.lock():
            scene.aim(viewer.cam, stature)
            viewer.cam.type = mujoco.mjtCamera.mjCAMERA_TRACKING
            viewer.cam.trackbodyid = model.body("torso").id
            viewer.opt.sitegroup[:] = 0
        _watch(viewer, session, model, pressed, stature, args.policy)


def _watch(
    viewer: Any,
    session: Session,
    model: mujoco.MjModel,
    pressed: queue.SimpleQueue[int],
    stature: float,
    name: str,
) -> None:
    """Window after window, each when its time has come; where pictures take long, several for each."""
    wishes, pace, scale = Wishes(), 1.0, stature / REFERENCE_HEIGHT
    due = drawn = time.perf_counter()
    while viewer.is_running():
        while not pressed.empty():
            wishes = keys.pressed(wishes, pressed.get())
        windows, due = due_windows(time.perf_counter(), due, session.window)
        for _ in range(windows):
            wishes = session.advance(wishes)
        with viewer.lock():
            viewer.user_scn.ngeom = 0
            if session.arrow is not None:
                scene.add_arrow(viewer.user_scn, model, session.data, session.arrow, scale)
        viewer.set_texts(_texts(session, wishes, name, pace))
        viewer.sync()
        time.sleep(max(0.0, due - time.perf_counter()))
        passed, drawn = time.perf_counter() - drawn, time.perf_counter()
        pace += min(1.0, passed / _PACE_SECONDS) * (windows * session.window / passed - pace)


def due_windows(now: float, due: float, window: float) -> tuple[int, float]:
    """How many windows, of ``window`` s each, are to be walked ``now``, and when the next one is due.

    Args:
      due: when the first of them should have begun, s.
    """
    behind = max(0.0, now - due)
    windows = 1 + int(behind / window)
    if windows > CATCH_UP:
        return CATCH_UP, now + window
    return windows, due + windows * window


def _texts(session: Session, wishes: Wishes, name: str, pace: float) -> list[tuple[int, int, str, str]]:
    """What is written into the window: (font, corner, names, values)."""
    lines = {
        "policy": name,
        "time": f"{session.seconds:.1f} s",
        "speed": f"{session.speed:.2f} m/s",
        "next push": f"{wishes.impulse:g} N s",
    }
    if session.arrow is not None:
        lines["pushed"] = f"{session.arrow.impulse:+g} N s"
    if session.fell is not None:
        lines["fell"] = f"at {session.fell:.1f} s: R starts anew"
        del lines["speed"]
    if wishes.paused:
        lines["paused"] = "space goes on"
    if pace < 0.95:
        lines["slow"] = f"{pace:.2f} of real time"
    font, grid = mujoco.mjtFontScale.mjFONTSCALE_150, mujoco.mjtGridPos
    return [
        (font, grid.mjGRID_TOPLEFT, "\n".join(lines), "\n".join(lines.values())),
        (font, grid.mjGRID_BOTTOMLEFT, "\n".join(dict(keys.HELP)), "\n".join(dict(keys.HELP).values())),
    ]
