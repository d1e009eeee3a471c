"""The trials of a push map: every combination, in one fixed order."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jaxwalk.model.push_points import PLACES, Point


@dataclass(frozen=True)
class Grid:
    """What is tried.

    Attributes:
      impulses: N s, ascending, forward positive.
      phases: of the step at which the push begins, each in [0, 1), ascending.
      points: pushed, by their names (see `push_points.Point`), in any order.
      durations: of the push, s.
      replicas: starts and noises for each combination.
      seed: of all of them.
    """

    impulses: tuple[float, ...]
    phases: tuple[float, ...]
    points: tuple[str, ...]
    durations: tuple[float, ...]
    replicas: int
    seed: int

    @classmethod
    def even(
        cls,
        impulses: tuple[float, ...],
        phases: int,
        points: tuple[str, ...],
        durations: tuple[float, ...],
        replicas: int,
        seed: int,
    ) -> Grid:
        """With so many ``phases``, evenly spread over the step."""
        return cls(impulses, tuple(i / phases for i in range(phases)), points, durations, replicas, seed)

    @property
    def shape(self) -> tuple[int, int, int, int, int]:
        """(durations, points, impulses, phases, replicas), the order of the trials."""
        return (
            len(self.durations),
            len(self.points),
            len(self.impulses),
            len(self.phases),
            self.replicas,
        )

    @property
    def size(self) -> int:
        """How many trials there are."""
        return int(np.prod(self.shape))

    def columns(self) -> dict[str, NDArray]:
        """[size] duration (s), point (name), impulse (N s) and phase of each trial."""
        axes = (self.durations, range(len(self.points)), self.impulses, self.phases, range(self.replicas))
        mesh = np.meshgrid(*[np.asarray(axis, np.float32) for axis in axes], indexing="ij")
        duration, point, impulse, phase, _ = (values.ravel() for values in mesh)
        names = np.asarray(self.points)[point.astype(int)]
        return {"duration": duration, "point": names, "impulse": impulse, "phase": phase}

    def where(self) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
        """[size] each trial's place, an index into `push_points.PLACES`, and height on the torso, m."""
        known = {name: Point.of(name) for name in self.points}
        points = [known[name] for name in self.columns()["point"].tolist()]
        return (
            np.array([PLACES.index(point.place) for point in points], np.int32),
            np.array([point.height for point in points], np.float32),
        )
