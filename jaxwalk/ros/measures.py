"""What the simulation node measures of a walk, and of the loop that it runs in."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

SETTLED = 3.0  # s before the speed is measured
LOW, LEANING = 0.6, 1.0  # of the hip's height at the start, rad: beyond them a walker has fallen


class Record:
    """Of ticks of ``timestep`` s.

    Attributes:
      fallen: the hip is too low, or the torso leans too far.
    """

    def __init__(self, timestep: float) -> None:
        self._timestep = timestep
        self._places: list[float] = []
        self._times: list[float] = []
        self._latencies: list[float] = []
        self._passive = self._missed = 0
        self._high = 0.0
        self.fallen = False

    def add(self, qpos: np.ndarray, command: tuple[float, ...], latency: float, now: float) -> None:
        """A tick, made at ``now`` (s) by ``command``, whose answer came ``latency`` s after its frame."""
        self._high = self._high or float(qpos[1])
        self._places.append(float(qpos[0]))
        self._times.append(now)
        if math.isfinite(latency):
            self._latencies.append(latency)
        else:
            self._missed += 1
        self._passive += not all(map(math.isfinite, command))
        stands = qpos[1] > LOW * self._high and abs(qpos[2]) < LEANING
        self.fallen = not stands

    def told(self, factor: float) -> dict[str, Any]:
        """As plain numbers; times in ms. NaN is what there was nothing to be measured of."""
        seconds, settled = len(self._places) * self._timestep, round(SETTLED / self._timestep)
        walked = self._places[settled:]
        speed = (walked[-1] - walked[0]) / ((len(walked) - 1) * self._timestep) if len(walked) > 1 else None
        periods = 1e3 * np.diff(self._times) if len(self._times) > 1 else np.zeros(1)
        late = 1e3 * np.array(self._latencies or [math.nan])
        took = self._times[-1] - self._times[0] if self._times else 0.0
        return {
            "seconds": seconds,
            "fell": self.fallen,
            "speed": speed,
            "ticks": len(self._places),
            "passive_ticks": self._passive,
            "unanswered_ticks": self._missed,
            "wall_seconds": took,
            "real_time_share": seconds / took / factor if took else None,
            "period": {"mean": float(periods.mean()), "jitter": float(periods.std()), "p99": _p99(periods)},
            "latency": {"mean": float(late.mean()), "p99": _p99(late)},
        }


def _p99(values: np.ndarray) -> float:
    return float(np.percentile(values, 99))
