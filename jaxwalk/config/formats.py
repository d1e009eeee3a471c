"""Configurations written down, now and before: in files of before, fields that came later mean what was so.

Files hold every field of their time (`to_dict`); one that is left out of theirs by hand has the default of
their format, where that was another one, or today's.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from jaxwalk.common.errors import UserError
from jaxwalk.config.schema import Config
from jaxwalk.config.validate import from_dict

_ONE_SPEED = {f"{name}_speed": 0.0 for name in ("length", "duration", "capture", "push_off")}
_BEFORE: dict[int, dict[str, Any]] = {
    1: {
        "physics": {"drives": "servo", "actuators": "unlimited", "contact_timeconst": 0.006},
        "gait": {
            "form": "rigid", "length_nominal": 0.633, "length_min": 0.45, "length_max": 0.95,
            "duration_nominal": 0.12, "duration_min": 0.05, "duration_max": 0.2,
        },
        "task": {"replan": 0},
        "observation": ["speed", "pitch", "zmp", "step_length", "pitch_rate"],
    },
    2: {
        "gait": {"steps": "told", "compliant": {"knee_stop": 0.0}},
        "task": {"replan": 1},
        "pushes": {"impulse_forward": 85.0, "impulse_backward": 90.0, "impulse_least": 0.45, "focus": 0.0},
        "reward": {"zmp_weight": 0.1},
        "ddpg": {
            "hidden": [64, 64], "actor_lr": 2e-4, "tau": 0.005, "batch_size": 256, "return_steps": 1,
            "action_weight": 0.0,
            "critic_head_start": 1_000, "updates_per_footstep": 0.5, "noise_start": 0.12, "noise_end": 0.04,
        },
        "observation": ["speed", "speed_desired", "pitch", "elapsed", "capture_ahead", "swing_ahead"],
    },
    3: {
        "gait": {
            "compliant": {
                "back_toe_off": 1.0, "toe_off_least": -1.0, "landing_behind": 100.0, "balance_ankle": 100.0,
                "ankle_stop": 0.0,
                **_ONE_SPEED,
            },
            "step_plan": {"pitch_least": -10.0, "back_latest": 0.0},
        },
        "reward": {"work_weight": 0.0},
        "circumstances": {"share": 0.0},
        "train": {"height_spread": 0.1, "mass_spread": 0.1, "footsteps": 80_000},
        "ddpg": {
            "actor_lr": 4e-4, "batch_size": 2_048, "critic_head_start": 300, "noise_start": 0.25,
            "noise_end": 0.15,
        },
        "pushes": {"impulse_forward": 130.0, "impulse_backward": 110.0},
    },
    4: {
        "gait": {"compliant": {"balance_sole": 100.0}, "step_plan": {"back_beyond": 1.0}},
        "ddpg": {"privileged": False, "hidden": [128, 128], "action_weight": 0.4},
        "train": {"footsteps": 40_000},
    },
    5: {"gait": {"compliant": {"lag_push_off": 0.0, "lag_pitch": 0.0, "lag_capture": 0.0}}},
    6: {
        "pushes": {"rate": 0.5, "rest": 0.0, "soon": 0.0, "impulse_least": 0.4},
        "ddpg": {
            "noise_seconds": 0.0, "noise_start": 0.12, "noise_end": 0.06, "action_weight": 4.0,
            "updates_per_footstep": 0.2, "replay_capacity": 262_144, "warmup": 4_000,
        },
        "train": {"walkers": 256, "footsteps": 100_000, "windows_per_report": 50},
        "circumstances": {"share": 0.5, "late": 2},
        "observation": [
            "speed", "speed_desired", "pitch", "pitch_rate", "acceleration", "elapsed", "capture_ahead",
            "swing_ahead",
        ],
    },
}  # fmt: skip
"""Defaults of each format that are others in the next, or had no field yet. In 1, which said no number,
walkers had rigid legs moved by servos and took one decision a step; in 2, policies commanded each step; in
3, a leg that steps back swung as any other, ankles turned without end, steps were of one speed, training had
one circumstance, and the paper's toe-off moved one leg; in 4, walkers balanced on the edge of a heel,
and waited for a foot that was far enough behind; in 5, nothing told them of a pack or a slope; in 6, pushes
came at any time, exploration shook each answer by itself, and policies were not told how late their
instruments are."""
FORMAT = 1 + len(_BEFORE)
"""Of configurations."""


def to_dict(config: Config) -> dict[str, Any]:
    """The configuration as plain JSON values, with the number of its format."""
    return {"format": FORMAT, **dataclasses.asdict(config)}


def of_dict(data: Any) -> Config:
    """The configuration that `to_dict` of this version or an earlier one made ``data`` of.

    Raises:
      UserError: a field that is not known, a value of the wrong type, or a later format.
    """
    if not isinstance(data, Mapping):
        return from_dict(Config, data)
    told = {name: value for name, value in data.items() if name != "format"}
    number = data.get("format", 1)
    if type(number) is not int or not 1 <= number <= FORMAT:
        raise UserError(f"configuration of format {number!r:.20}: this version reads 1 to {FORMAT}")
    for older in range(number, FORMAT):
        told = _filled(told, _BEFORE[older])
        if older == 1 and isinstance(physics := _at(told, "physics"), dict):  # heel and toe had one number
            physics.setdefault("heel_timeconst", physics["contact_timeconst"])
        if older == 3 and isinstance(gait := _at(told, "gait"), dict) and gait.get("toe_off_form") == "paper":
            told["gait"] = {**gait, "toe_off_form": "one-leg"}
        if older == 3 and isinstance(legs := _at(told, "gait", "compliant"), dict):
            for name in ("pitch_gain", "knee", "knee_stiffness", "knee_damping"):
                if f"swing_{name}" in legs:
                    legs.setdefault(f"back_{name}", legs[f"swing_{name}"])
    return from_dict(Config, told)


def _at(told: Any, *names: str) -> Any:
    """What lies there; None where the file holds something else than it should."""
    for name in names:
        told = told.get(name) if isinstance(told, dict) else None
    return told


def _filled(told: dict[str, Any], defaults: dict[str, Any]) -> dict[str, Any]:
    """``told`` with what it does not say."""
    full = dict(told)
    for name, values in defaults.items():
        given = told.get(name, {})
        if not isinstance(values, dict):
            full.setdefault(name, values)
        elif isinstance(given, Mapping):
            full[name] = _filled(dict(given), values)
    return full
