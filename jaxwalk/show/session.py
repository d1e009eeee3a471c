"""What was done on a page of ``jaxwalk play``, as the page saves it: read, and walked again.

The page simulates what the package does, so that settings, seed and what came at which tick are all that a
session is.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jax.numpy as jnp
import mujoco

from jaxwalk.common import untrusted
from jaxwalk.common.errors import UserError
from jaxwalk.config import DELAY_MOST, validate
from jaxwalk.learn.policies import named
from jaxwalk.learn.policies.named import Subject
from jaxwalk.model.burdens import Burden
from jaxwalk.model.push_points import PLACES
from jaxwalk.options import checks
from jaxwalk.show import recording
from jaxwalk.show.recording import Loop, Shove, Walk
from jaxwalk.task.stepper import Stepper

FORMAT = 1
LARGEST = 1 << 20  # bytes of a file
LONGEST = 600.0  # s
_CURE = "give what a page of jaxwalk play has saved"


@dataclass(frozen=True)
class Settings:
    """Who walks, and where.

    Attributes:
      seed: of start and noise. height: m. mass: kg. speed: desired, m/s. noise: scale of the sensors'.
      slope: degrees, uphill positive. friction: of the soles. delay: of instruments, s. strength: a share.
    """

    seed: int
    height: float
    mass: float
    speed: float
    noise: float
    slope: float
    friction: float
    delay: float
    strength: float


@dataclass(frozen=True)
class Session:
    """What was done on the page.

    Attributes:
      policy: its name on the page. digest: of its parameters. shown: who walked, by name.
      settings: at the start.
      events: (tick, what): settings that change, and ``push``, a `Shove`.
      ticks: how long was walked.
    """

    policy: str
    digest: str
    shown: tuple[str, ...]
    settings: Settings
    events: tuple[tuple[int, dict[str, Any]], ...]
    ticks: int


def read(file: Path) -> Session:
    """The session that a page saved.

    Raises:
      UserError: there is no such file, or it is no session.
    """
    told = untrusted.read_json(file, _CURE, LARGEST)
    try:
        return _session(told)
    except (untrusted.Bad, UserError, KeyError, TypeError, ValueError) as error:
        raise UserError(untrusted.unreadable(file, error, _CURE)) from None


def _session(told: Any) -> Session:
    if not isinstance(told, dict) or told.get("format") != FORMAT:
        raise untrusted.Bad(f"no session of format {FORMAT}")
    settings = validate.from_dict(Settings, told["settings"], "settings")
    _check(settings)
    ticks, shown = told["ticks"], tuple(told["shown"])
    policy, digest = told["policy"]["name"], told["policy"]["digest"]
    named_so = all(isinstance(x, str) for x in (policy, digest, *shown))
    if not named_so or type(ticks) is not int or not ticks > 0:
        raise untrusted.Bad("its policy, who is shown, or its ticks are none")
    events, met = [], settings
    for tick, what in told["events"]:
        if type(tick) is not int or not (events[-1][0] if events else 0) <= tick <= ticks:
            raise untrusted.Bad(f"an event at {tick!r:.40}")
        if not isinstance(what, dict):
            raise untrusted.Bad(f"an event that is {what!r:.40}")
        push = what.get("push")
        changed = {name: x for name, x in what.items() if name != "push"}
        if changed.keys() & {"seed", "height", "mass"}:
            raise untrusted.Bad("who walks does not change on the way")
        met = validate.from_dict(Settings, dataclasses.asdict(met) | changed, "events")
        _check(met)
        events.append((tick, changed | ({} if push is None else {"push": _shove(push)})))
    return Session(policy, digest, shown, settings, tuple(events), ticks)


def _check(settings: Settings) -> None:
    checks.seed(settings.seed)
    checks.walker(settings)
    checks.between("settings.slope", settings.slope, -10.0, 10.0, " degrees")
    checks.between("settings.friction", settings.friction, 0.01, 2.0, "")
    checks.between("settings.delay", settings.delay, 0.0, DELAY_MOST, " s")
    checks.between("settings.strength", settings.strength, 0.01, 2.0, "")


def _shove(told: Any) -> Shove:
    shove = validate.from_dict(Shove, {"time": 0.0} | told, "push")
    checks.between("push.impulse", shove.impulse, -1000.0, 1000.0, " N s")
    checks.between("push.height", shove.height, -1.0, 1.0, " m")
    checks.between("push.place", shove.place, 0, len(PLACES) - 1, "")
    return shove


def subject(policy: str, file: Path) -> Subject:
    """``policy`` as the session in ``file`` has its body, speed and noise.

    Raises:
      UserError: as `read`, and for a policy that did not walk there.
    """
    found = read(file)
    own = found.settings
    loaded = named.load(policy, speed=own.speed, height=own.height, mass=own.mass, noise=own.noise)
    if named.origin(policy) is None:  # a rule, whose parameters change with the speed
        walked = policy in found.shown
    else:
        walked = loaded.digest == found.digest and found.policy in found.shown
    if not walked:
        raise UserError(f"--session {file}: was walked by {', '.join(found.shown)}, not by this {policy}")
    return loaded


def record(subject: Subject, session: Session, model: mujoco.MjModel) -> Walk:
    """Walk as on the page.

    Args:
      model: as for `recording.walked`.

    Raises:
      UserError: it lasts too long.
    """
    loop, own = Loop(subject, 1), session.settings
    checks.between("--session: seconds", session.ticks * loop.timestep, 0.0, LONGEST, "")
    todo, met, given = [*session.events], {}, []

    def meet(tick: int, state: Stepper) -> Stepper:
        while todo and todo[0][0] <= tick:
            _, what = todo.pop(0)
            met.update({name: x for name, x in what.items() if name != "push"})
            state = _changed(state, dataclasses.replace(own, **met))
            if "push" in what:
                lasts = subject.config.pushes.duration
                shove = dataclasses.replace(what["push"], time=tick * loop.timestep, duration=lasts)
                given.append(loop.whole(shove))
                state = loop.pushed(state, shove)
        return state

    walk = recording.walked(loop, model, session.ticks, loop.start(own.seed, _burden(own)), meet)
    return dataclasses.replace(walk, pushes=tuple(given))


def _burden(settings: Settings) -> Burden:
    slope = jnp.deg2rad(jnp.float32(settings.slope))
    own = {name: jnp.float32(getattr(settings, name)) for name in ("friction", "strength", "delay")}
    none = {name: jnp.float32(0) for name in ("mass", "ahead", "up", "force")}
    return Burden(slope=slope, **own, **none)


def _changed(state: Stepper, settings: Settings) -> Stepper:
    """``state`` as it goes on under ``settings``."""
    body = state.walker
    gait = dataclasses.replace(body.person.gait, speed_desired=jnp.float32(settings.speed))
    person = body.person.replace(gait=gait, burden=_burden(settings))
    noise = body.sensors.replace(noise=jnp.float32(settings.noise))
    return state.replace(walker=body.replace(person=person, sensors=noise))
