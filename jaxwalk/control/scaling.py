"""The controllers' numbers of another body than the reference one."""

from __future__ import annotations

import dataclasses
from typing import Any

import jax

from jaxwalk.config import CompliantConfig, GaitConfig, StepPlanConfig
from jaxwalk.config.gait import SWITCHES
from jaxwalk.model.similarity import Similarity

# The controllers' numbers may be traced (one set for each walker of a batch): tuning needs that.
jax.tree_util.register_dataclass(
    GaitConfig,
    data_fields=[f.name for f in dataclasses.fields(GaitConfig) if f.name not in SWITCHES],
    meta_fields=list(SWITCHES),
)

for _part in (CompliantConfig, StepPlanConfig):
    jax.tree_util.register_dataclass(
        _part, data_fields=[f.name for f in dataclasses.fields(_part)], meta_fields=[]
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
_COMPLIANT = {
    "hip_damping": "rotational_damping",
    "hip_rate_max": "rate",
    "hip_speed_min": "speed",
    "knee_stiffness": "torque",
    "knee_damping": "rotational_damping",
    "knee_seconds": "time",
    "ankle_stiffness": "torque",
    "ankle_damping": "rotational_damping",
    "push_off_torque": "torque",
    "toe_off_seconds": "time",
    "swing_stiffness": "torque",
    "swing_damping": "rotational_damping",
    "swing_rate_max": "rate",
    "swing_acceleration_most": "angular_acceleration",
    "swing_soonest": "time",
    "swing_knee_stiffness": "torque",
    "swing_knee_damping": "rotational_damping",
    "knee_stop": "torque",
    "landing_knee_stiffness": "torque",
    "landing_knee_damping": "rotational_damping",
    "landing_seconds": "time",
    "swing_ankle_stiffness": "torque",
    "swing_ankle_damping": "rotational_damping",
    "landing_time": "time",
    "landing_capture": "length",
    "landing_behind": "length",
    "speed_usual": "speed",
    "length_speed": "time",
    "capture_speed": "time",
    "passing_seconds": "time",
    "ankle_stop": "torque",
    "back_knee_stiffness": "torque",
    "back_knee_damping": "rotational_damping",
    "back_ahead": "length",
    "back_force": "force",
    "lag_seconds": "time",
    "lag_speed": "speed",
    "lag_most": "length",
}
_STEP_PLAN = {
    "change_length": "length",
    "change_duration": "time",
    "pitch_gain": "length",
    "length_least": "length",
    "duration_least": "time",
    "duration_most": "time",
    "back_margin": "length",
    "back_reach": "length",
    "back_least": "length",
    "back_speed": "speed",
    "back_time": "time",
    "back_latest": "time",
    "back_soonest": "time",
}


def scaled(config: GaitConfig, body: Similarity) -> GaitConfig:
    """The controllers' numbers for a body, by dynamic similarity."""

    def each(own: Any, kinds: dict[str, str]) -> dict[str, Any]:
        return {name: getattr(own, name) * getattr(body, kind) for name, kind in kinds.items()}

    values = each(config, _DIMENSION)
    # Torque per speed.
    values["toe_off_gain"] = config.toe_off_gain * body.torque / body.speed
    own, plan = config.compliant, config.step_plan
    legs = each(own, _COMPLIANT)
    legs["push_off_gain"] = own.push_off_gain * body.torque / body.speed
    legs["push_off_speed"] = own.push_off_speed * body.torque / body.speed
    legs["duration_speed"] = own.duration_speed * body.time / body.speed
    legs["ankle_capture_gain"] = own.ankle_capture_gain * body.torque / body.length
    legs["lag_push_off"] = own.lag_push_off * body.torque / body.length
    legs["lag_pitch"] = own.lag_pitch / body.length
    legs["pitch_capture_gain"] = own.pitch_capture_gain / body.length
    steps = each(plan, _STEP_PLAN)
    steps["duration_gain"] = plan.duration_gain * body.time / body.length
    return dataclasses.replace(
        config,
        **values,
        compliant=dataclasses.replace(own, **legs),
        step_plan=dataclasses.replace(plan, **steps),
    )
