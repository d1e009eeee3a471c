"""Who walks: the exported numbers, which are the reference body's, carried to a stature and a mass."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np

from jaxwalk.common.errors import UserError
from jaxwalk.config import CompliantConfig, GaitConfig, StepPlanConfig
from jaxwalk.config.gait import RIGID, SHARED

_LATER = {
    "compliant_knee_stop": 0.0, "compliant_back_toe_off": 1.0, "compliant_balance_ankle": 100.0,
    "compliant_ankle_stop": 0.0, "compliant_ankle_end": 1.0, "compliant_speed_usual": 0.0,
    "compliant_length_speed": 0.0, "compliant_duration_speed": 0.0, "compliant_capture_speed": 0.0,
    "compliant_push_off_speed": 0.0, "plan_pitch_least": -10.0, "plan_back_latest": 0.0,
    "compliant_swing_soonest": 0.03, "compliant_swing_acceleration_most": 400.0,
    "compliant_toe_off_least": -1.0, "compliant_landing_behind": 100.0,
    "compliant_balance_sole": 100.0, "plan_back_beyond": 1.0, "compliant_lag_seconds": 6.0,
    "compliant_lag_speed": 0.3, "compliant_lag_most": 0.6, "compliant_lag_push_off": 0.0,
    "compliant_lag_pitch": 0.0, "compliant_lag_capture": 0.0,
}  # fmt: skip
"""Numbers of compliant legs and their plan that files of before do not tell, with what they meant."""
_AS_SWING = ("pitch_gain", "knee", "knee_stiffness", "knee_damping")
"""What a step back had no number of its own of, in such files."""
PARTS: dict[str, tuple[str, Any]] = {
    "compliant": ("compliant_", CompliantConfig),
    "step_plan": ("plan_", StepPlanConfig),
}
"""Parts of the controllers' numbers, those of compliant legs: what their names begin with."""


@dataclass(frozen=True)
class Person:
    """One walker's own numbers, float32.

    Attributes:
      length, mass: ratios to the reference body.
      gait: the controllers' numbers.
      thigh, shank, foot, torso: hip to knee, knee to ankle, ankle to sole, hip to the torso's centre, m.
      torso_share: of the mass of the body that the torso's lean moves.
      torso_inertia: about the hip, kg m^2. half_leg: mass of each half of a leg, kg.
      ankle_damping: N m s/rad. ankle_limit: largest torque, N m.
      delay: by which its instruments of torso and soles tell late, s, as the policy is told.
      strength: [2, 3, 3] forward and back; of each the largest torque (N m), and the rates (rad/s) at which
        three quarters and half of it are left; of hip, knee and ankle of the reference body. None: no limit.
    """

    length: np.float32
    mass: np.float32
    gait: GaitConfig
    thigh: np.float32
    shank: np.float32
    foot: np.float32
    torso: np.float32
    torso_share: np.float32
    torso_inertia: np.float32
    half_leg: np.float32
    ankle_damping: np.float32
    ankle_limit: np.float32
    delay: np.float32
    strength: np.ndarray | None = None

    @property
    def leg(self) -> np.float32:
        """Hip height of a straight leg (``L`` of the paper), m."""
        return self.thigh + self.shank + self.foot

    @property
    def speed(self) -> np.float32:
        """This body's speeds over those of the reference body."""
        return np.sqrt(self.length)

    @property
    def torque(self) -> np.float32:
        """This body's torques over those of the reference body."""
        return self.mass * self.length

    @property
    def rate(self) -> np.float32:
        """This body's angular velocities over those of the reference body."""
        return np.float32(1) / np.sqrt(self.length)


def build(manifest: dict[str, Any], height: float | None = None, mass: float | None = None) -> Person:
    """The walker of ``height`` m and ``mass`` kg; by default the one the policy was trained around.

    Raises:
      UserError: a stature or a mass out of range.
      KeyError, TypeError, ValueError: a manifest that is damaged.
    """
    height = _number(manifest["person"]["height"] if height is None else height)
    mass = _number(manifest["person"]["mass"] if mass is None else mass)
    if not 0.5 <= height <= 3.0:
        raise UserError(f"height {height} m: give a stature between 0.5 and 3 m")
    if not 5.0 <= mass <= 500.0:
        raise UserError(f"mass {mass} kg: give a mass between 5 and 500 kg")
    reference = manifest["reference"]
    length = np.float32(height) / np.float32(_number(reference["height"]))
    heavy = np.float32(mass) / np.float32(_number(reference["mass"]))

    def scaled(one: dict[str, Any]) -> np.float32:
        value, by_length, by_mass = (np.float32(_number(one[name])) for name in ("value", "length", "mass"))
        return value * length**by_length * heavy**by_mass

    switches, numbers = manifest["switches"], manifest["numbers"]
    told = {"form": "rigid", "steps": "told"} | switches  # which files of before do not say
    if "speeds" not in manifest and told.get("toe_off_form") == "paper":  # a file of before
        told["toe_off_form"] = "one-leg"
    own = {name: scaled(numbers[name]) for name in _BODY}
    parts: dict[str, Any] = {}
    for part, (prefix, kind) in PARTS.items():
        fields = [f.name for f in dataclasses.fields(kind)]
        needed = told["form"] == "compliant" and (part != "step_plan" or told["steps"] == "planned")
        keys = {name: f"{prefix}{name}" for name in fields if needed or f"{prefix}{name}" in numbers}
        told_of = _of_before(numbers) | numbers
        parts[part] = kind(**{name: scaled(told_of[key]) for name, key in keys.items()})
    names = [f.name for f in dataclasses.fields(GaitConfig) if f.name not in (*told, *PARTS)]
    needed = SHARED if told["form"] == "compliant" else RIGID
    gait: dict[str, Any] = {n: scaled(numbers[n]) for n in names if n in numbers or n in needed}
    strength = manifest.get("strength")
    return Person(
        length=length,
        mass=heavy,
        gait=GaitConfig(**gait, **told, **parts),
        delay=np.float32(0),
        strength=None if strength is None else np.array(strength, np.float32).reshape(2, 3, 3),
        **own,
    )


def _of_before(numbers: dict[str, Any]) -> dict[str, Any]:
    """What files of before do not tell."""
    constant = {name: {"value": x, "length": 0.0, "mass": 0.0} for name, x in _LATER.items()}
    swing = {f"compliant_back_{name}": numbers.get(f"compliant_swing_{name}") for name in _AS_SWING}
    return constant | swing


def _number(value: Any) -> float:
    """``value``, which is one number; NumPy would make an array of a list."""
    if isinstance(value, bool | str) or np.ndim(value):
        raise TypeError("not a number")
    return float(value)


_OTHERS = ("length", "mass", "gait", "strength", "delay")
_BODY = tuple(f.name for f in dataclasses.fields(Person) if f.name not in _OTHERS)
