"""What an exported policy carries inside: names, units, bounds, version, and the controllers' numbers.

Plain JSON values. Every number of the controllers is that of the reference body and says how it goes with
stature and mass, so that a runtime needs no table of its own.
"""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import fields
from typing import Any

import jax.numpy as jnp

from jaxwalk import __version__
from jaxwalk.config import GRAVITY, REFERENCE_HEIGHT, REFERENCE_MASS, BodyConfig, Config
from jaxwalk.config.gait import RIGID, SHARED, SWITCHES
from jaxwalk.control import posture, scaling, sensors
from jaxwalk.control.person import Person, inertias
from jaxwalk.deploy.file import FORMAT_VERSION
from jaxwalk.deploy.person import PARTS
from jaxwalk.learn.policies import policy
from jaxwalk.model import anthropometry, kinematics, strength
from jaxwalk.model.engine import Setup
from jaxwalk.model.similarity import Similarity

OBSERVATION_UNITS = {
    "speed": "m/s", "pitch": "rad", "zmp": "m", "step_length": "m", "pitch_rate": "rad/s",
    "acceleration": "m/s^2", "speed_desired": "m/s", "height": "1", "com_ahead": "m", "elapsed": "s",
    "capture_ahead": "m", "swing_ahead": "m", "delay": "s",
}  # fmt: skip
ACTION_UNITS = {"length": "m", "duration": "s"}

_UNITS = {
    "m": "length_nominal length_min length_max back_step_margin back_step_reach back_step_least "
    "touchdown_ahead thigh shank foot torso",
    "s": "duration_nominal duration_min duration_max toe_off_duration toe_off_duration_min "
    "toe_off_duration_max restart_seconds stall_seconds",
    "m/s": "speed_desired stance_speed_min toe_off_speed",
    "rad": "pitch_nominal swing_knee swing_ankle toe_off_ankle back_step_knee back_step_near fall_pitch",
    "rad/s": "stance_rate_max swing_rate_max",
    "1/s": "terminal_hip_gain",
    "N": "back_step_force touchdown_force",
    "N m": "toe_off_full restart_torque ankle_limit",
    "N m/rad": "ankle_stiffness",
    "N m s/rad": "ankle_rate_gain ankle_damping",
    "N m s/m": "toe_off_gain",
    "kg": "half_leg",
    "kg m^2": "torso_inertia",
    "1": "swing_pitch_gain swing_knee_share touchdown_share fall_height torso_share",
}
_COMPLIANT_UNITS = {
    "rad": "pitch_nominal pitch_offset knee_loading knee_standing ankle_slack push_off_angle push_off_ramp "
    "push_off_ankle balance_ankle balance_sole ankle_end swing_knee back_knee landing_knee swing_sole "
    "swing_ankle_most",
    "rad/s": "hip_rate_max swing_rate_max",
    "rad/s^2": "swing_acceleration_most",
    "rad/m": "pitch_capture_gain lag_pitch",
    "m": "landing_capture landing_behind back_ahead lag_most",
    "m/s": "hip_speed_min speed_usual lag_speed",
    "s^2/m": "duration_speed",
    "s": "length_speed capture_speed "
    "knee_seconds toe_off_seconds landing_seconds landing_time passing_seconds swing_soonest "
    "lag_seconds",
    "N": "back_force",
    "N m": "push_off_torque",
    "N m/m": "ankle_capture_gain lag_push_off",
    "N m/rad": "knee_stiffness ankle_stiffness ankle_stop swing_stiffness swing_knee_stiffness knee_stop "
    "back_knee_stiffness landing_knee_stiffness swing_ankle_stiffness",
    "N m s/rad": "hip_damping knee_damping ankle_damping swing_damping swing_knee_damping "
    "back_knee_damping landing_knee_damping swing_ankle_damping",
    "N m s/m": "push_off_gain push_off_speed",
    "1": "push_off_share swing_pitch_gain toe_off_knee_share landing_share back_toe_off back_pitch_gain "
    "toe_off_least lag_capture",
}
_STEP_PLAN_UNITS = {
    "m": "change_length length_least back_margin back_reach back_least",
    "s": "change_duration duration_least duration_most back_time back_latest back_soonest",
    "m/s": "back_speed",
    "m/rad": "pitch_gain",
    "rad": "pitch_least",
    "s/m": "duration_gain",
    "1": "length_gain back_gain back_beyond",
}
UNITS = {
    f"{prefix}{name}": unit
    for prefix, units in (
        ("", _UNITS), (PARTS["compliant"][0], _COMPLIANT_UNITS), (PARTS["step_plan"][0], _STEP_PLAN_UNITS),
    )
    for unit, names in units.items()
    for name in names.split()
}  # fmt: skip

_JOINTS = [f"{joint}_{side}" for side in ("left", "right") for joint in ("hip", "knee", "ankle")]
SENSORS = (
    [("velocity", "m/s"), ("acceleration", "m/s^2"), ("pitch", "rad"), ("pitch_rate", "rad/s")]
    + [(f"{joint}_angle", "rad") for joint in _JOINTS]
    + [(f"{joint}_rate", "rad/s") for joint in _JOINTS]
    + [("touch_left", "N"), ("touch_right", "N")]
)
"""What a tick takes, in this order."""
_TOLD = {
    "rigid": (("hip_rate", "rad/s"), ("knee_angle", "rad"), ("ankle_torque", "N m")),
    "compliant": (("hip_torque", "N m"), ("knee_torque", "N m"), ("ankle_torque", "N m")),
}
COMMANDS = {
    form: [(f"{what}_{side}", unit) for side in ("left", "right") for what, unit in told]
    for form, told in _TOLD.items()
}
"""What a tick gives, in this order, by the form of the controllers."""


def build(trained: policy.Policy, config: Config) -> dict[str, Any]:
    """The manifest of ``trained``, whose run's configuration is ``config``."""
    meta = trained.metadata
    gain = sensors.kalman_gain(config.sensors, config.physics.timestep)
    bounds = zip(meta.action_names, meta.action_low, meta.action_high, strict=True)
    return {
        "format_version": FORMAT_VERSION,
        "jaxwalk_version": __version__,
        "origin": {
            "seed": meta.seed,
            "footsteps": meta.footsteps,
            "score": meta.score,
            "model": config.body.model,
        },
        "observation": [{"name": name, "unit": OBSERVATION_UNITS[name]} for name in meta.observation_names],
        "observation_clip": meta.observation_clip,
        "action": [
            {"name": name, "unit": ACTION_UNITS[name], "low": low, "high": high} for name, low, high in bounds
        ],
        "hidden": list(meta.hidden),
        "reference": {"height": REFERENCE_HEIGHT, "mass": REFERENCE_MASS},
        "person": {"height": config.body.height, "mass": config.body.mass},
        "speeds": _speeds(config),
        "delay_trained": _delay_trained(config),
        "timestep": config.physics.timestep,
        "gravity": GRAVITY,
        "sensors": {"mean_window": config.sensors.mean_window, "kalman_gain": gain.tolist()},
        "switches": {name: getattr(config.gait, name) for name in SWITCHES},
        "numbers": {name: number | {"unit": UNITS[name]} for name, number in _numbers(config)},
        "sensor_inputs": [{"name": name, "unit": unit} for name, unit in SENSORS],
        "commands": [{"name": name, "unit": unit} for name, unit in COMMANDS[config.gait.form]],
        "decisions": {"replan": config.task.replan, "window_ticks": config.train.window_ticks},
        "strength": _strength(config),
    }


def text(manifest: dict[str, Any]) -> str:
    """A manifest as JSON text, as files carry it."""
    return json.dumps(manifest, allow_nan=False)


def _strength(config: Config) -> list[list[list[float]]] | None:
    """As `jaxwalk.deploy.person.Person` has it."""
    own = strength.STRENGTHS.get(config.physics.actuators)
    if own is None:
        return None
    return [[list(x[way]) for x in (own.most, own.three_quarters, own.half)] for way in (0, 1)]


def _delay_trained(config: Config) -> float:
    """The latest instruments that the policy was trained with and told of, s."""
    met = config.circumstances
    return met.delay if met.share and "delay" in config.observation else 0.0


def _speeds(config: Config) -> list[float]:
    """[least, greatest] speed that the policy was trained for, m/s."""
    spread = config.circumstances.speed if config.circumstances.share else 0.0
    return [config.gait.speed_desired - spread, config.gait.speed_desired + spread]


def _numbers(config: Config) -> Iterator[tuple[str, dict[str, float]]]:
    gait = config.gait
    names = RIGID if gait.form == "rigid" else SHARED
    # Numbers of 1 in their place, since what is 0 would not tell how it scales.
    parts = {
        part: kind(**dict.fromkeys((f.name for f in fields(kind)), 1.0)) for part, (_, kind) in PARTS.items()
    }
    ones = dataclasses.replace(gait, **dict.fromkeys(RIGID, 1.0), **parts)
    ratios = [Similarity(jnp.float32(length), jnp.float32(mass)) for length, mass in _RATIOS]
    found = [scaling.scaled(ones, ratio) for ratio in ratios]
    for name in names:
        yield name, _number([getattr(x, name) for x in found], getattr(gait, name))
    for part, (prefix, kind) in PARTS.items() if gait.form == "compliant" else ():
        for name in (f.name for f in fields(kind)):
            value = getattr(getattr(gait, part), name)
            yield f"{prefix}{name}", _number([getattr(getattr(x, part), name) for x in found], value)

    reference = anthropometry.build(BodyConfig(table=config.body.table))
    setup = Setup.of(config)
    bones = [kinematics.skeleton(reference, ratio.length) for ratio in ratios]
    for name in ("thigh", "shank", "foot", "torso"):
        yield name, _number([getattr(x, name) for x in bones])
    named = {"torso_inertia": "torso", "half_leg": "leg_mass", "ankle_damping": "damping"}
    held = [inertias(setup, Person(ratio, gait)) for ratio in ratios]
    for name, field in named.items():
        yield name, _number([getattr(x, field) for x in held])
    yield "ankle_limit", _number([config.physics.ankle_limit * ratio.torque for ratio in ratios])
    yield "torso_share", _number([posture.TORSO_SHARE] * len(_RATIOS))


_RATIOS = (1.0, 1.0), (2.0, 1.0), (1.0, 2.0)
"""Of stature and mass: the reference body; twice its stature; twice its mass."""


def _number(at: Sequence[Any], value: float | None = None) -> dict[str, float]:
    """A number, and the powers of stature and mass that it goes with.

    Args:
      at: what it is at each of `_RATIOS`. value: itself; default: the first of those.
    """
    here, longer, heavier = map(float, at)

    def power(there: float) -> float:
        return round(2 * math.log2(there / here)) / 2 if here else 0.0

    return {
        "value": here if value is None else value,
        "length": power(longer),
        "mass": power(heavier),
    }
