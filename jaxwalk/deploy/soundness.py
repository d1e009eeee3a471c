"""Which readings can be true: all numbers, none beyond what a walker's instruments can say.

A reading that cannot is left out: the last one that could stands for it, for `HOLD_SECONDS` on end. Then the
joints are let go, until the controller is started again.
"""

from __future__ import annotations

import numpy as np

from jaxwalk.common.errors import UserError
from jaxwalk.deploy.sensors import Sensors

HOLD_SECONDS = 0.02
_SHAPES = {"velocity": (), "acceleration": (), "pitch": (), "pitch_rate": (), "joints": (2, 3)}
_SHAPES |= {"joint_rates": (2, 3), "touch": (2,)}
_TURN, _ANGLES = np.float32(np.pi), slice(4, 10)
MOST = np.array([100, 1e4, _TURN, 1e3, *[_TURN] * 6, *[1e3] * 6, *[1e6] * 2], np.float32)
"""[18] the largest size of each input, in the order of `Sensors`: m/s, m/s^2, rad, rad/s, rad, rad/s, N."""


def hold_ticks(timestep: float) -> int:
    """Ticks of ``timestep`` s that a reading stands for later ones."""
    return max(1, round(HOLD_SECONDS / timestep))


def flat(said: Sensors) -> np.ndarray:
    """[18] float32, in the order of `Sensors`.

    Raises:
      UserError: a part has another shape than `Sensors` says.
    """
    for name, shape in _SHAPES.items():
        if (found := np.shape(getattr(said, name))) != shape:
            raise UserError(f"sensors' {name}: give the shape {shape}, not {found}")
    parts = (np.ravel(getattr(said, name)) for name in _SHAPES)
    with np.errstate(over="ignore"):  # what becomes infinite is none to be read
        return np.concatenate([np.asarray(part, np.float32) for part in parts])


def of_flat(told: np.ndarray) -> Sensors:
    """What `flat` makes ``told`` of."""
    velocity, acceleration, pitch, pitch_rate = told[:4]
    legs = told[4:16].reshape(2, 2, 3)
    return Sensors(velocity, acceleration, pitch, pitch_rate, legs[0], legs[1], told[16:])


def read(said: Sensors) -> Sensors | None:
    """``said`` in float32 and of its own; None: it cannot be true.

    Raises:
      UserError: as of `flat`.
    """
    told = flat(said)
    if not bool(np.all(np.abs(told) <= MOST)):  # no comparison holds of what is not a number
        return None
    return of_flat(told)


def check_angles(said: Sensors) -> None:
    """See that angles are in radians.

    Raises:
      UserError: a joint or the torso is turned by more than half a turn.
    """
    told = flat(said)
    for name, value in (("pitch", told[2]), *(("joints", x) for x in told[_ANGLES])):
        if np.isfinite(value) and abs(value) > _TURN:
            raise UserError(f"sensors' {name} {value:g}: give radians, -3.14 to 3.14")
