"""``jaxwalk demo``: the exported controller walks and is pushed on C MuJoCo, and a page replays it."""

from __future__ import annotations

import os
import sys
import tempfile
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Console

from jaxwalk import deploy
from jaxwalk.common import files
from jaxwalk.config import Config
from jaxwalk.export import command as export
from jaxwalk.learn.policies import named
from jaxwalk.show import scene
from jaxwalk.show.recording import Footfall, Shove, Walk
from jaxwalk.show.replay_page import replay
from jaxwalk.show.replay_page.replay import Replay
from jaxwalk.task import deployed

if TYPE_CHECKING:
    from jaxwalk.demo.options import DemoArgs

POLICY = "shipped"
IMPULSES = (None, 40.0, 70.0, -40.0, -80.0)  # N s; the first walk has no push
SECONDS = 8.0
_BY = "C MuJoCo, the exported controller"
DELAY = 0.1  # s into the footstep at which a push begins


def main(args: DemoArgs) -> None:
    """Run ``jaxwalk demo``.

    Raises:
      UserError: the file cannot be written.
    """
    console = Console(markup=False)
    with console.status("walking, and being pushed"):
        recorded = record()
        page = replay.html(recorded, named.origin(POLICY), "jaxwalk demo", _BY)
    files.write_bytes(args.out, page)
    console.print(f"{args.out.resolve()}: the shipped policy walks, and is pushed", highlight=False)
    if args.open and _has_browser():
        webbrowser.open(args.out.resolve().as_uri())
    else:
        console.print("open that file in a browser", highlight=False)


def record() -> Replay:
    """The shipped policy's walks, every one alike until its push."""
    subject = named.load(POLICY)
    with tempfile.TemporaryDirectory() as folder:
        file = export.write(*export.load(POLICY), ("npz",), Path(folder))["npz"]
        controller = deploy.Controller.load(file)
    walks = []
    for impulse in IMPULSES:
        asked = None if impulse is None else deployed.Shove(impulse, DELAY)
        walked = deployed.walk(subject.config, controller, SECONDS, 0, asked, keep=True)
        walks.append(_seen(subject.config, walked, impulse))
    return Replay(subject, 0, tuple(walks), scene.model(subject.config))


def _seen(config: Config, walked: deployed.Walk, impulse: float | None) -> tuple[Walk, Shove | None]:
    """``walked`` as the page draws it."""
    dt = config.physics.timestep
    begun = None if walked.pushed is None else walked.pushed * dt
    shove = None if impulse is None or begun is None else Shove(impulse, begun)
    walk = Walk(
        qpos=np.stack(walked.qpos),
        timestep=dt,
        push=None if shove is None else (shove.time, shove.time + shove.duration),
        fell=walked.seconds if walked.fell else None,
        speed=np.array(walked.speeds, np.float64),
        footfalls=tuple(_footfalls(walked, dt)),
    )
    return walk, shove


def _footfalls(walked: deployed.Walk, dt: float) -> list[Footfall]:
    found, before = [], 0.0
    for tick, leg, length in walked.landings:
        found.append(Footfall(tick * dt, leg, length, tick * dt - before))
        before = tick * dt
    return found


def _has_browser() -> bool:
    shown = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    if sys.platform.startswith("linux") and not shown:
        return False  # or one in the terminal would take it over
    try:
        webbrowser.get()
    except webbrowser.Error:
        return False
    return True
