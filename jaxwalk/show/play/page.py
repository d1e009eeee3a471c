"""The page on which a walker can be pushed: what its scripts are told, and the file."""

from __future__ import annotations

import base64
import dataclasses
import shlex
from typing import Any

import jax.numpy as jnp
import numpy as np

from jaxwalk import __version__
from jaxwalk.common.errors import UserError
from jaxwalk.config import DELAY_MOST, GRAVITY, REFERENCE_HEIGHT, REFERENCE_MASS, Config
from jaxwalk.control import person, posture
from jaxwalk.kernels import portable
from jaxwalk.learn.policies import named, policy
from jaxwalk.learn.policies.named import Subject
from jaxwalk.model import kinematics
from jaxwalk.model.push_points import PLACES
from jaxwalk.show import scene
from jaxwalk.show.play import module, program
from jaxwalk.show.web import document, figure
from jaxwalk.show.web import origin as origin_of
from jaxwalk.show.web.document import Document
from jaxwalk.task.stepper import Task

_HOME = "jaxwalk.show.play"
SCRIPTS = ("walker.js", "session.js", "map.js", "scene.js", "page.js")
MOST = 300.0  # N s that a push by hand may have
RULES = ("replan", "constant")


def html(subject: Subject, origin: policy.Metadata | None, command: str) -> bytes:
    """The page, an HTML file.

    Args:
      origin: of the policy; None for a rule. command: the line that makes the page.

    Raises:
      UserError: there is no module that walks as ``subject`` does.
    """
    config = subject.config
    facts = origin_of.facts(subject, origin)
    facts += [
        ("Simulated", f"in this page, {1 / config.physics.timestep:g} ticks a second, as jaxwalk does"),
        ("Pushes", f"{config.pushes.duration:g} s; the first walker's phase counts from its landing"),
        ("This page", f"jaxwalk {__version__}: {command}"),
    ]
    lead = f"{subject.name}, simulated here: take hold of it, and push it."
    return document.render(Document(_HOME, SCRIPTS, subject.name, lead, facts, content(subject)))


def content(subject: Subject) -> dict[str, Any]:
    """What the scripts are told, plain JSON values.

    Raises:
      UserError: as for `html`.
    """
    config = subject.config
    rules = [named.load(name) for name in RULES if name != subject.name]
    walkers = [_controller(one) for one in (subject, *rules)]
    reference = dataclasses.replace(config.body, height=REFERENCE_HEIGHT, mass=REFERENCE_MASS)
    setup = Task.of(config).setup
    bones = kinematics.skeleton(person.reference_body(setup), jnp.float32(1))
    return {
        "version": __version__,
        "policy": {"name": subject.name, "digest": subject.digest, "quoted": shlex.quote(subject.name)},
        "timestep": config.physics.timestep,
        "window": setup.window_ticks,
        "push": config.pushes.duration,
        "gravity": GRAVITY,
        "most": MOST,
        "places": list(PLACES),
        "stature": REFERENCE_HEIGHT,
        "figure": figure.figure(scene.model(dataclasses.replace(config, body=reference))),
        "body": {
            "leg": float(bones.leg),
            "torso": float(bones.torso),
            "share": posture.TORSO_SHARE,
            "weight": REFERENCE_MASS * GRAVITY,
        },
        "sliders": _sliders(config),
        "controllers": walkers,
        "modules": {name: _module(name) for name in sorted({one["module"] for one in walkers})},
    }


def _sliders(config: Config) -> dict[str, Any]:
    """What a reader may change; bounds are those of training, or a step more. ``fixed``: by a new start
    alone. ``times``: shown times that, in ``unit``."""

    def of(label: str, unit: str, bounds: tuple[float, float], step: float, value: float, **more: Any) -> Any:
        low, high = min(bounds[0], value), max(bounds[1], value)
        return {"label": label, "unit": unit, "low": low, "high": high, "step": step, "value": value} | more

    body = config.body
    return {
        "height": of("Stature", "m", (1.4, 2.3), 0.01, body.height, fixed=True),
        "mass": of("Mass", "kg", (35.0, 160.0), 1.0, body.mass, fixed=True),
        "speed": of("Speed asked for", "m/s", (0.6, 1.4), 0.05, config.gait.speed_desired),
        "noise": of("Sensor noise, 1 realistic", "×", (0.0, 4.0), 0.25, config.sensors.noise),
        "slope": of("Slope, uphill positive", "°", (-4.0, 4.0), 0.5, 0.0),
        "friction": of("Friction", "", (0.2, 1.2), 0.05, config.physics.friction),
        "delay": of("Instruments late by", "ms", (0.0, DELAY_MOST), 0.002, 0.0, times=1000),
        "strength": of("Motors' strength", "%", (0.5, 1.0), 0.05, 1.0, times=100),
    }


def _controller(subject: Subject) -> dict[str, Any]:
    config = subject.config
    told = answers(subject)
    name = module.name_of(config, subject.name, adapts=bool(told[0]))
    what = "the policy" if subject.act is policy.act else _WHAT.get(subject.name, "never adapts its step")
    return {
        "name": subject.name,
        "what": what,
        "module": name,
        "numbers": _base64(_given(config, name)),
        "answers": _base64(told),
    }


_WHAT = {"replan": "plans, learns nothing"}


def _given(config: Config, name: str) -> np.ndarray:
    """[G] what a start is given, but for what a reader may change."""
    places = module.load(name).given
    leaves = portable.named({"numbers": config.gait})
    given = np.zeros(sum(int(np.prod(shape, dtype=int)) for _, shape, _ in places.values()), np.float32)
    for key, value in leaves.items():
        given[places[key][0]] = value
    return given


def answers(subject: Subject) -> np.ndarray:
    """[N] what ``subject`` answers, in the form that `program` reads: layers of a network, or one answer.

    Raises:
      UserError: a rule that answers now this, now that; a layer of more than `program.WIDEST` units.
    """
    if subject.act is policy.act:
        return _network(subject)
    count = len(subject.config.observation)
    told = [np.asarray(subject.act(subject.params, jnp.full(count, x))) for x in (0.0, 1.0)]
    if (told[0] != told[1]).any():
        raise UserError(f"policy {subject.name}: a page has no such rule: give a policy, replan or constant")
    return np.concatenate([[0.0], told[0]]).astype(np.float32)


def _network(subject: Subject) -> np.ndarray:
    trained = subject.params
    tensors, meta = policy.tensors(trained), trained.metadata
    sizes = [len(meta.observation_names), *meta.hidden, len(meta.action_names)]
    if max(sizes) > program.WIDEST:
        raise UserError(f"policy {subject.name}: a page's layers have {program.WIDEST} units at most")
    limit = np.inf if meta.observation_clip is None else meta.observation_clip
    names = [*(f"hidden_{i}" for i in range(len(meta.hidden))), "output"]
    layers = [tensors[f"actor/{name}/{leaf}"].ravel() for name in names for leaf in ("kernel", "bias")]
    seen = tensors["observation/mean"], tensors["observation/std"]
    return np.concatenate([[len(names), *sizes, limit], *seen, *layers]).astype(np.float32)


def _module(name: str) -> dict[str, Any]:
    kept = module.load(name)
    return {"code": base64.b64encode(kept.code).decode(), "given": kept.given, "state": kept.state}


def _base64(numbers: np.ndarray) -> str:
    return base64.b64encode(np.ascontiguousarray(numbers, "<f4").tobytes()).decode()
