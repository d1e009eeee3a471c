"""The controllers' numbers of another body than the reference one."""

from __future__ import annotations

import dataclasses
from typing import Any

import jax

from jaxwalk.config import GaitConfig
from jaxwalk.model.similarity import Similarity

# The controllers' numbers may be traced (one set for each walker of a batch): tuning needs that.
SWITCHES = ("toe_off_form", "toe_off_latched", "back_step")
jax.tree_util.register_dataclass(
    GaitConfig,
    data_fields=[f.name for f in dataclasses.fields(GaitConfig) if f.name not in SWITCHES],
    meta_fields=list(SWITCHES),
)

# How the reference body's numbers scale; what is not named is a pure number or an angle.
_DIMENSION = {
    "length_nominal": "length",
    "duration_nominal": "time",
    "length_min": "length",
    "length_max": "length",
    "duration_min": "time",
    "duration_max": "time",
    "stance_rate_max": "rate",
    "stance_speed_min": "speed",
    "swing_rate_max": "rate",
    "terminal_hip_gain": "rate",
    "ankle_stiffness": "torque",
    "ankle_rate_gain": "rotational_damping",
    "toe_off_duration": "time",
    "toe_off_duration_min": "time",
    "toe_off_duration_max": "time",
    "toe_off_full": "torque",
    "back_step_margin": "length",
    "back_step_reach": "length",
    "back_step_least": "length",
    "back_step_force": "force",
    "restart_seconds": "time",
    "restart_torque": "torque",
    "touchdown_ahead": "length",
    "touchdown_force": "force",
    "stall_seconds": "time",
}


def scaled(config: GaitConfig, body: Similarity) -> GaitConfig:
    """The controllers' numbers for a body, by dynamic similarity."""
    values: dict[str, Any] = {
        name: getattr(config, name) * getattr(body, kind) for name, kind in _DIMENSION.items()
    }
    # Torque per speed.
    values["toe_off_gain"] = config.toe_off_gain * body.torque / body.speed
    return dataclasses.replace(config, **values)
