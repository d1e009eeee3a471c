"""The step's clock: which leg stands, for how long, and what step it was told to take."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jaxwalk.deploy.kinematics import Posture


@dataclass(frozen=True)
class Clock:
    """Where in its step a walker is.

    Attributes:
      stance: index of the stance leg, 0 left, 1 right.
      elapsed: since the last touch-down, s.
      length, duration: commanded, of the step under way: length (m), and the time of its early swing (rigid)
        or of the whole step (compliant), s.
      toe_off, toe_off_seconds: of the trailing ankle, N m, plantarflexion positive, and s.
      change: of the planned length (m) and duration (s), as the policy wants it, of steps that are planned.
      path, path_rate: where the swing hip shall be, rad, rad/s; of compliant legs.
      lag: how far the walker has fallen behind the speed asked for of late, m; likewise.
    """

    stance: int
    elapsed: np.float32
    length: np.float32
    duration: np.float32
    toe_off: np.float32
    toe_off_seconds: np.float32
    path: np.float32
    path_rate: np.float32
    lag: np.float32
    change: tuple[np.float32, np.float32] = (np.float32(0), np.float32(0))

    @property
    def swing(self) -> int:
        """Index of the leg that is not in stance, 0 left, 1 right."""
        return 1 - self.stance


def step_length(posture: Posture, clock: Clock) -> np.float32:
    """How far the swing ankle is ahead of the stance ankle, m."""
    return posture.x[clock.swing] - posture.x[clock.stance]
