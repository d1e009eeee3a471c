"""The trials of a push map: every combination, in one fixed order."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Grid:
    """What is tried.

    Attributes:
      impulses: N s, ascending, forward positive.
      phases: of the step at which the push begins, each in [0, 1), ascending.
      heights: of the point pushed above the torso's centre, m.
      durations: of the push, s.
      replicas: starts and noises for each combination.
      seed: of all of them.
    """

    impulses: tuple[float, ...]
    phases: tuple[float, ...]
    heights: tuple[float, ...]
    durations: tuple[float, ...]
    replicas: int
    seed: int

    @property
    def shape(self) -> tuple[int, int, int, int, int]:
        """(durations, heights, impulses, phases, replicas), the order of the trials."""
        return (
            len(self.durations),
            len(self.heights),
            len(self.impulses),
            len(self.phases),
            self.replicas,
        )

    @property
    def size(self) -> int:
        """Trials."""
        return int(np.prod(self.shape))

    def columns(self) -> dict[str, NDArray[np.float32]]:
        """[size] duration, height, impulse and phase of each trial."""
        axes = (self.durations, self.heights, self.impulses, self.phases, range(self.replicas))
        mesh = np.meshgrid(*[np.asarray(axis, np.float32) for axis in axes], indexing="ij")
        names = ("duration", "height", "impulse", "phase")
        return {name: values.ravel() for name, values in zip(names, mesh, strict=False)}
