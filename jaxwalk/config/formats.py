"""Configurations written down, now and before: what a file lacks means what it meant when it was written."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from jaxwalk.common.errors import UserError
from jaxwalk.config.schema import Config
from jaxwalk.config.validate import from_dict

FORMAT = 2
"""Of configurations. In 1, which said no number, walkers had rigid legs moved by servos and took one
decision a step."""

_FIRST: dict[str, Any] = {
    "physics": {"drives": "servo", "actuators": "unlimited", "contact_timeconst": 0.006},
    "gait": {
        "form": "rigid", "length_nominal": 0.633, "length_min": 0.45, "length_max": 0.95,
        "duration_nominal": 0.12, "duration_min": 0.05, "duration_max": 0.2,
    },
    "task": {"replan": 0},
    "observation": ["speed", "pitch", "zmp", "step_length", "pitch_rate"],
}  # fmt: skip
"""Defaults of format 1 that are others today, or had no field yet."""


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
    return from_dict(Config, told if number == FORMAT else _from_first(told))


def _from_first(told: dict[str, Any]) -> dict[str, Any]:
    """``told`` of format 1, with what it did not say."""
    full = dict(told)
    for name, values in _FIRST.items():
        given = told.get(name, {})
        if not isinstance(values, dict):
            full.setdefault(name, values)
        elif isinstance(given, Mapping):
            full[name] = {**values, **given}
    if isinstance(physics := full["physics"], dict):  # one number was that of heel and toe
        physics.setdefault("heel_timeconst", physics["contact_timeconst"])
    return full
