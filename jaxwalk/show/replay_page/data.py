"""Recorded walks as compact JSON: whole millimetres, milliradians and milliseconds, and back."""

from __future__ import annotations

from typing import Any

import numpy as np

from jaxwalk.model import mjcf
from jaxwalk.show.recording import Walk, camera_path

POSE_SECONDS = 0.01  # about so long from pose to pose
UNIT = 1e-3  # what a whole number stands for: m, rad, m/s, s
COLUMNS = ("x", "z", "pitch", *mjcf.PLANAR.joints[3:])
"""Names of a pose's numbers, in the order of the planar ``qpos``."""


def stride(walk: Walk) -> int:
    """Ticks from one pose of the page to the next."""
    return max(1, round(POSE_SECONDS / walk.timestep))


def encode(walk: Walk) -> dict[str, Any]:
    """One walk, and the first push in it; ``columns``, ``camera`` and ``speed`` hold a value per pose, in
    thousandths of SI units.

    ``speed`` ends at a fall. ``footfalls``: (time, leg, length, seconds) each, see `recording.Footfall`.
    """
    step, push = stride(walk), None
    for shove in walk.pushes[:1]:
        end = shove.time + shove.duration
        push = {"impulse": shove.impulse, "start": shove.time, "end": end, "height": shove.height}
    return {
        "push": push,
        "fell": walk.fell,
        "step": round(step * walk.timestep, 9),
        "columns": {name: _whole(values) for name, values in zip(COLUMNS, walk.qpos[::step].T, strict=True)},
        "camera": _whole(camera_path(walk)[::step]),
        "speed": _whole(walk.speed[::step]),
        "footfalls": [
            [*_whole(np.array([f.time])), f.leg, *_whole(np.array([f.length, f.seconds]))]
            for f in walk.footfalls
        ],
    }


def poses(encoded: dict[str, Any]) -> np.ndarray:
    """[P, 9] ``qpos`` of an encoded walk, ``encoded["step"]`` s apart.

    Raises:
      KeyError, TypeError, ValueError: it is not what `encode` gives.
    """
    return np.stack([np.asarray(encoded["columns"][name], np.float64) for name in COLUMNS], axis=1) * UNIT


def _whole(values: np.ndarray) -> list[int]:
    return np.rint(np.asarray(values, np.float64) / UNIT).astype(int).tolist()
