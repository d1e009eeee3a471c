"""A policy's walks, unpushed and pushed, recorded and put on a page."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from jaxwalk import __version__
from jaxwalk.common.errors import UserError
from jaxwalk.config import Engine
from jaxwalk.learn.policies import policy
from jaxwalk.learn.policies.named import Subject
from jaxwalk.model import physics
from jaxwalk.show import recording, scene
from jaxwalk.show.recording import Shove, Walk
from jaxwalk.show.replay_page import data
from jaxwalk.show.web import document, figure
from jaxwalk.show.web import origin as origin_of
from jaxwalk.show.web.document import Document

FILE = "replay.html"
SECONDS = 10.0  # of a walk
PUSH_SECOND = 3.0  # the steady gait is reached, and what follows a push has time to end


@dataclass(frozen=True)
class Replay:
    """What was recorded; every walk starts alike, so that they differ from the push on.

    Attributes:
      subject: who walked. seed: of the starts and the noise.
      walks: their poses as the planar model's; the first has no push.
      model: of the body, as it is drawn.
    """

    subject: Subject
    seed: int
    walks: tuple[Walk, ...]
    model: mujoco.MjModel


def record(
    subject: Subject,
    impulses: Sequence[float],
    seed: int,
    report: Callable[[str], None] = lambda what: None,
    engine: Engine = "mjx",
) -> Replay:
    """Walk unpushed, then once for each of ``impulses``, N s, on the torso's centre.

    Args:
      report: called with what comes next.
      engine: what moves the walkers.
    """
    loop, model = recording.Loop(subject, recording.SEGMENT, engine), scene.model(subject.config)
    where = physics.layout(subject.config.body)
    walks = []
    for shove in (None, *(Shove(impulse, PUSH_SECOND) for impulse in impulses)):
        report("walking unpushed" if shove is None else f"walking, pushed by {shove.impulse:+g} N s")
        walk = recording.record(loop, model, SECONDS, seed, shove)
        walks.append(dataclasses.replace(walk, qpos=where.planar(walk.qpos)))
    return Replay(subject, seed, tuple(walks), model)


def content(replay: Replay) -> dict[str, Any]:
    """What the page's script draws, plain JSON values: ``figure``, ``stature`` (m) and ``walks``."""
    return {
        "stature": replay.subject.config.body.height,
        "figure": figure.figure(replay.model),
        "walks": [data.encode(walk) for walk in replay.walks],
    }


def html(replay: Replay, origin: policy.Metadata | None, command: str) -> bytes:
    """The page that replays the walks, an HTML file.

    Args:
      origin: of the policy; None for a rule.
      command: the line that makes the page.
    """
    config = replay.subject.config
    speed = f"{config.gait.speed_desired:g} m/s"
    facts = origin_of.facts(replay.subject, origin)
    moved = f"MJX, {1 / config.physics.timestep:g} ticks a second"
    begins = {shove.time for walk in replay.walks for shove in walk.pushes}
    since = " or ".join(f"{second:g}" for second in sorted(begins))
    facts += [
        ("Body", f"{config.body.height:g} m, {config.body.mass:g} kg"),
        ("Speed asked for", speed),
        ("Walks", f"seed {replay.seed}, sensor noise {config.sensors.noise:g}; {moved}"),
        ("Pushes", f"{Shove(0, 0).duration:g} s at the torso's centre, from {since} s on"),
        ("This page", f"jaxwalk {__version__}: {command}"),
    ]
    lead = f"Recorded walks at {speed}, and the pushes in them, as the simulation ran them."
    home, name = "jaxwalk.show.replay_page", replay.subject.name
    return document.render(Document(home, ("page.js",), name, lead, facts, content(replay)))


def verify(path: Path, replay: Replay) -> float:
    """Read the file back as a browser does: largest difference of a pose from the recorded one, m or rad.

    Raises:
      UserError: it is no such page, would load something, or shows other poses.
    """
    anew = "do not use it, and report this"
    try:
        found, addresses = document.read(path.read_bytes())
        worst = max(
            float(np.abs(data.poses(one) - walk.qpos[:: data.stride(walk)]).max())
            for one, walk in zip(found["walks"], replay.walks, strict=True)
        )
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise UserError(f"{path}: cannot be read back ({error}): {anew}") from None
    if addresses:
        raise UserError(f"{path}: would load {addresses[0]}: {anew}")
    if not worst <= 0.51 * data.UNIT:
        raise UserError(f"{path}: a pose differs from the recorded one by {worst:.2g} m or rad: {anew}")
    return worst
