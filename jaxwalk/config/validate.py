"""Configurations from outside: decoded from JSON values, and checked for sense."""

from __future__ import annotations

import dataclasses
import math
import types
import typing
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Literal, TypeVar

from jaxwalk.common.errors import UserError
from jaxwalk.config.compliant import CompliantConfig
from jaxwalk.config.schema import Config
from jaxwalk.config.walker import DELAY_MOST, BodyConfig, PidConfig

T = TypeVar("T")


def from_dict(cls: type[T], data: Any, where: str = "") -> T:
    """A dataclass from the plain values that ``dataclasses.asdict`` and JSON make of it.

    Missing fields take their defaults, so that older files stay readable.

    Args:
      cls: dataclass whose fields are scalars, Literals, optional or homogeneous tuples of
        these, or dataclasses.
      data: mapping from field names to values.
      where: dotted path of ``data`` for messages.

    Raises:
      UserError: a field that ``cls`` does not have, or a value of the wrong type.
    """
    if not isinstance(data, Mapping):
        raise UserError(f"{where or cls.__name__}: expected a table of fields, got {data!r:.60}")
    hints = typing.get_type_hints(cls)
    unknown = sorted(set(data) - set(hints))
    if unknown:
        name = _join(where, unknown[0])
        raise UserError(f"unknown field {name:.60}: this version knows {', '.join(hints)}")
    return cls(**{name: _decode(hints[name], value, _join(where, name)) for name, value in data.items()})


def _join(where: str, name: str) -> str:
    return f"{where}.{name}" if where else name


def _decode(kind: Any, value: Any, where: str) -> Any:
    origin, args = typing.get_origin(kind), typing.get_args(kind)
    if dataclasses.is_dataclass(kind):
        return from_dict(typing.cast(type, kind), value, where)
    if origin is Literal:
        if value in args:
            return value
        raise UserError(f"{where} = {value!r:.60}: give one of {', '.join(map(str, args))}")
    if origin in (typing.Union, types.UnionType):
        if value is None and type(None) in args:
            return None
        (kind,) = (arg for arg in args if arg is not type(None))
        return _decode(kind, value, where)
    if origin is tuple:
        if not isinstance(value, list | tuple):
            raise UserError(f"{where} = {value!r:.60}: give a list")
        return tuple(_decode(args[0], item, f"{where}[{i}]") for i, item in enumerate(value))
    if kind is Path and isinstance(value, str):
        return Path(value)
    # bool is an int to Python, but 1 for a switch or true for a count is a mistake in a file.
    if kind is float and isinstance(value, int | float) and not isinstance(value, bool):
        return float(value)
    if type(value) is not kind:
        raise UserError(f"{where} = {value!r:.60}: give a value of type {kind.__name__}")
    return value


# Fields by the sense their values must have. Bodies are `person`'s to judge.
_POSITIVE = """
    physics.timestep physics.iterations physics.ls_iterations physics.contact_timeconst physics.heel_timeconst
    physics.friction circumstances.friction circumstances.strength circumstances.late
    sensors.mean_window gait.speed_desired gait.pitch_nominal
    gait.toe_off_full gait.toe_off_duration_min gait.stall_seconds gait.fall_height gait.fall_pitch
    physics.hip_gain physics.hip_limit physics.knee_stiffness physics.knee_damping physics.knee_limit
    physics.ankle_limit physics.abduction_limit physics.gazebo.knee_position_gain physics.gazebo.knee_rate_max
    physics.gazebo.retraction_seconds pushes.duration ddpg.actor_lr ddpg.critic_lr ddpg.batch_size
    ddpg.replay_capacity ddpg.return_steps ddpg.noise_spread ddpg.policy_delay
    train.walkers train.footsteps train.window_ticks train.episode_seconds
    es.generations es.candidates es.walkers es.seconds es.sigma
    train.windows_per_report train.evaluations train.finalists
    train.divergence_events
""".split()
_NOT_NEGATIVE = """
    physics.tolerance physics.ankle_damping physics.abduction_gain physics.abduction_integral
    sensors.noise circumstances.pack circumstances.slope circumstances.noise circumstances.delay
    circumstances.speed pushes.rate pushes.rest reward.speed_tolerance
    pushes.impulse_forward pushes.impulse_backward pushes.height_spread ddpg.warmup
    ddpg.critic_head_start ddpg.action_weight
    ddpg.updates_per_footstep ddpg.noise_start ddpg.noise_end ddpg.noise_seconds ddpg.weight_decay
    ddpg.max_grad_norm
    ddpg.target_noise ddpg.target_noise_clip train.checkpoint_seconds train.divergence_limit task.replan
""".split()
_NOT_NEGATIVE += [
    f"physics.gazebo.{joint}.{gain.name}"
    for joint in ("hip", "knee", "ankle", "abduction")
    for gain in dataclasses.fields(PidConfig)
]
_POSITIVE += [f"gait.step_plan.{name}" for name in ("change_length", "change_duration", "back_speed")]
_POSITIVE += [
    f"gait.compliant.{name}"
    for name in (
        "pitch_nominal", "knee_seconds", "push_off_ramp", "swing_soonest", "swing_acceleration_most",
        "lag_seconds", "lag_speed", "lag_most",
    )
]  # fmt: skip
_NOT_NEGATIVE += [
    f"gait.compliant.{field.name}"
    for field in dataclasses.fields(CompliantConfig)
    if field.name.endswith(("_stiffness", "_damping", "_seconds", "_max", "_stop", "_share", "_toe_off"))
]
_BELOW_ONE = [
    "ddpg.gamma",
    "pushes.focus",
    "pushes.impulse_least",
    "train.height_spread",
    "train.mass_spread",
]  # 0 <= x < 1


def check(config: Config) -> None:
    """See that a configuration can be run at all.

    Raises:
      UserError: the first field without sense, named as on the command line.
    """
    person(config.body)
    values = dict(leaves(config))
    for name, choices in _choices(type(config)):
        _require(values[name] in choices, name, values[name], f"one of {', '.join(map(str, choices))}")
    for name, value in values.items():
        if isinstance(value, float):
            _require(math.isfinite(value), name, value, "a finite number")
        elif isinstance(value, int):
            _require(value < 2**31, name, value, f"at most {2**31 - 1}")
    for name in _POSITIVE:
        _require(values[name] > 0, name, values[name], "a number above 0")
    for name in _NOT_NEGATIVE:
        _require(values[name] >= 0, name, values[name], "0 or more")
    for name in _BELOW_ONE:
        _require(0 <= values[name] < 1, name, values[name], "a number from 0 up to, not including, 1")
    ddpg, gait = config.ddpg, config.gait
    _require(
        config.reward.work_weight == 0 or config.physics.drives == "torque",
        "reward.work-weight",
        config.reward.work_weight,
        "0, for the work of joints that are not moved by torques is not measured",
    )
    met = config.circumstances
    for name, share in (("circumstances.share", met.share), ("pushes.soon", config.pushes.soon)):
        _require(0 <= share <= 1, name, share, "a number from 0 to 1")
    _require(met.delay <= DELAY_MOST, "circumstances.delay", met.delay, f"at most {DELAY_MOST:g} s")
    _require(met.slope <= 10, "circumstances.slope", met.slope, "at most 10 degrees")
    _require(met.pack <= 100, "circumstances.pack", met.pack, "at most 100 kg")
    _require(met.strength <= 1, "circumstances.strength", met.strength, "at most 1")
    _require(
        met.speed <= gait.speed_desired - 0.1 or not met.share,
        "circumstances.speed",
        met.speed,
        f"0.1 m/s less than --gait.speed-desired, {gait.speed_desired:g} m/s, or still less",
    )
    for name, share in (("ddpg.tau", ddpg.tau), ("ddpg.average_rate", ddpg.average_rate)):
        _require(0 < share <= 1, name, share, "a number above 0, at most 1")
    _require(
        bool(ddpg.hidden) and min(ddpg.hidden) > 0,
        "ddpg.hidden",
        ddpg.hidden,
        "one width or more, each above 0",
    )
    _require(
        ddpg.batch_size <= ddpg.replay_capacity,
        "ddpg.batch_size",
        ddpg.batch_size,
        f"at most --ddpg.replay-capacity, {ddpg.replay_capacity}",
    )
    _require(
        gait.length_min < gait.length_nominal < gait.length_max and gait.length_nominal > 0,
        "gait.length-nominal",
        gait.length_nominal,
        "length-min < length-nominal < length-max, and above 0",
    )
    _require(
        gait.length_min > 0 or gait.form == "compliant",
        "gait.length-min",
        gait.length_min,
        "a number above 0: rigid legs are not told to step back",
    )
    _require(
        0 < gait.duration_min < gait.duration_nominal < gait.duration_max,
        "gait.duration-nominal",
        gait.duration_nominal,
        "0 < duration-min < duration-nominal < duration-max",
    )
    _require(
        gait.toe_off_duration_min <= gait.toe_off_duration <= gait.toe_off_duration_max,
        "gait.toe-off-duration",
        gait.toe_off_duration,
        "toe-off-duration-min <= toe-off-duration <= toe-off-duration-max",
    )
    physics = config.physics
    _require(
        physics.contact_timeconst >= 2 * physics.timestep,
        "physics.contact-timeconst",
        physics.contact_timeconst,
        f"at least two time steps, {2 * physics.timestep:g} s",
    )
    _require(
        physics.drives != "gazebo" or gait.toe_off_latched,
        "physics.drives",
        physics.drives,
        "servo, or --gait.toe-off-latched too: an effort is set once",
    )
    compliant = gait.form == "compliant"
    _require(
        (physics.drives == "torque") == compliant,
        "physics.drives",
        physics.drives,
        "torque for compliant legs, servo or gazebo for rigid ones (--gait.form)",
    )
    _require(
        compliant or gait.steps == "told",
        "gait.steps",
        gait.steps,
        "told: rigid legs take the step that the policy commands (--gait.form)",
    )
    plan = gait.step_plan
    for least, most in (("duration_least", "duration_most"), ("back_soonest", "back_time")):
        shortest, longest = (getattr(plan, name) for name in (least, most))
        _require(
            shortest <= longest,
            f"gait.step_plan.{least}",
            shortest,
            f"at most --gait.step-plan.{most.replace('_', '-')}, {longest:g}",
        )
    _require(
        compliant or physics.actuators == "unlimited",
        "physics.actuators",
        physics.actuators,
        "unlimited: rigid legs are moved by servos, whose limits are --physics.hip-limit and its like",
    )
    _require(
        physics.heel_timeconst >= 2 * physics.timestep,
        "physics.heel-timeconst",
        physics.heel_timeconst,
        f"at least two time steps, {2 * physics.timestep:g} s",
    )
    again = config.task.replan * config.train.window_ticks * physics.timestep
    _require(
        again == 0 or (compliant and again < gait.duration_nominal),
        "task.replan",
        config.task.replan,
        f"windows that are over before the nominal step is, {gait.duration_nominal:g} s"
        if compliant
        else "0: rigid legs settle their step at touch-down",
    )
    distinct = bool(config.observation) and len(set(config.observation)) == len(config.observation)
    _require(distinct, "observation", config.observation, "one quantity or more, each once")


def person(config: BodyConfig) -> None:
    """See that such a person can be built.

    Raises:
      UserError: height outside 0.5..3 m, mass outside 5..500 kg, or an unknown table.
    """
    if not 0.5 <= config.height <= 3.0:
        raise UserError(f"body height {config.height} m: give a stature between 0.5 and 3 m")
    if not 5.0 <= config.mass <= 500.0:
        raise UserError(f"body mass {config.mass} kg: give a mass between 5 and 500 kg")
    tables = typing.get_args(typing.get_type_hints(BodyConfig)["table"])
    if config.table not in tables:
        raise UserError(f"body table {config.table!r}: give one of {', '.join(tables)}")


def leaves(config: Any, where: str = "") -> Iterator[tuple[str, Any]]:
    """(dotted name, value) of every field of a configuration or of a part of it."""
    for field in dataclasses.fields(config):
        value, name = getattr(config, field.name), _join(where, field.name)
        if dataclasses.is_dataclass(value):
            yield from leaves(value, name)
        else:
            yield name, value


def _choices(kind: Any, where: str = "") -> Iterator[tuple[str, tuple[Any, ...]]]:
    """(dotted name, what it may be) of every field that is one of a few."""
    for name, hint in typing.get_type_hints(kind).items():
        if dataclasses.is_dataclass(hint):
            yield from _choices(hint, _join(where, name))
        elif typing.get_origin(hint) is Literal:
            yield _join(where, name), typing.get_args(hint)


def _require(ok: bool, name: str, value: Any, right: str) -> None:
    if not ok:
        shown = " ".join(map(str, value)) or "(none)" if isinstance(value, tuple) else value
        raise UserError(f"--{name.replace('_', '-')} {shown}: give {right}")
