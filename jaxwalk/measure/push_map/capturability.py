"""How hard a walker can be pushed at all: limits of the linear inverted pendulum.

Koolen, de Boer, Rebula, Goswami & Pratt, "Capturability-based analysis and control of legged
locomotion", Int. J. Robotics Research 31(9), 2012. The body is a point at constant height z above a
massless leg; what decides is the instantaneous capture point x + v / omega, measured from the
stance ankle. Lengths in m, times in s, speeds in m/s; every function takes NumPy arrays too.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jaxwalk.config import GRAVITY

REDIRECT_SECONDS = 0.1  # from a push to a swing foot that lands elsewhere, at the soonest

Times = float | NDArray[np.floating]


@dataclass(frozen=True)
class Pendulum:
    """A walker as a pendulum.

    Attributes:
      height: of the centre of mass, z, m.
      mass: kg.
      step: usual step length s, m. seconds: usual step time T, s.
      longest: step length l that it can take, m. shortest: step time that it can take, s.
      half_foot: how far the centre of pressure can be ahead of the ankle, r, m.
    """

    height: float
    mass: float
    step: float
    seconds: float
    longest: float
    shortest: float
    half_foot: float = 0.0

    @property
    def omega(self) -> float:
        """sqrt(g / z), 1/s."""
        return math.sqrt(GRAVITY / self.height)

    @property
    def offset(self) -> float:
        """b0: how far the capture point of steady walking is ahead of the foot at touch-down, m."""
        return self.step / math.expm1(self.omega * self.seconds)


def capture_distance(pendulum: Pendulum, steps: int | float = math.inf) -> float:
    """d_N: how far ahead of the foot a capture point may be at touch-down, to come to rest within N steps.

    d_0 = r, d_N = r + (l + d_{N-1} - r) exp(-omega dt), which for N without end is r + l e / (1 - e).
    """
    r, decay = pendulum.half_foot, math.exp(-pendulum.omega * pendulum.shortest)
    if math.isinf(steps):
        return r + pendulum.longest * decay / (1 - decay)
    distance = r
    for _ in range(int(steps)):
        distance = r + (pendulum.longest + distance - r) * decay
    return distance


def forward_fixed(pendulum: Pendulum, time: Times) -> Times:
    """A: largest impulse from behind, N s, at ``time`` s into a step whose landing stays as planned."""
    omega, left = pendulum.omega, pendulum.seconds - np.asarray(time, float)
    room = capture_distance(pendulum) - pendulum.offset
    return pendulum.mass * omega * room * np.exp(-omega * left)


def forward_replanned(pendulum: Pendulum, time: Times) -> Times:
    """B: the same if the step in flight is at once made the longest and soonest that can be.

    The foot lands no sooner than the shortest step, nor than `REDIRECT_SECONDS` after the push.
    """
    omega, time = pendulum.omega, np.asarray(time, float)
    left = np.maximum(pendulum.shortest - time, REDIRECT_SECONDS)
    reach = (pendulum.longest + capture_distance(pendulum)) * np.exp(-omega * left)
    return pendulum.mass * omega * (reach - pendulum.offset * np.exp(omega * time))


def backward(pendulum: Pendulum, time: Times) -> Times:
    """C: largest impulse from the front, N s (positive), of a walker that cannot step back.

    The capture point, offset exp(omega t) ahead of the foot, may be thrown back to the foot.
    """
    omega = pendulum.omega
    return pendulum.mass * omega * pendulum.offset * np.exp(omega * np.asarray(time, float))
