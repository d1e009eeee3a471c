"""Where the legs are, from joint angles alone; computed once a tick."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jaxwalk.deploy.person import Person


@dataclass(frozen=True)
class Posture:
    """Where both legs are, left and right.

    Attributes:
      thigh, shank: [2] from the vertical, forward positive, rad.
      x, z: [2] of the ankles from the hip, m (x forward, z up).
    """

    thigh: np.ndarray
    shank: np.ndarray
    x: np.ndarray
    z: np.ndarray


def posture(who: Person, joints: np.ndarray, pitch: np.float32) -> Posture:
    """The posture of [2, 3] joint angles (rad) under a torso of ``pitch`` rad."""
    thigh = joints[:, 0] - pitch
    shank = thigh - joints[:, 1]
    return Posture(
        thigh=thigh,
        shank=shank,
        x=who.thigh * np.sin(thigh) + who.shank * np.sin(shank),
        z=-(who.thigh * np.cos(thigh) + who.shank * np.cos(shank)),
    )
