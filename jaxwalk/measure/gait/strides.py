"""Gait cycles out of sole forces: from touch-down to the next touch-down of the same leg."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float

POINTS = 101  # of a normalised cycle: 0, 1, ... 100 per cent
BOUNCE_SECONDS = 0.04  # a gap in contact, or a contact, that is shorter is none


@dataclass(frozen=True)
class Cycle:
    """One gait cycle of one leg; ticks of the recording that it was found in.

    Attributes:
      side: of the leg, 0 left, 1 right.
      start, stop: its touch-down, and the next one.
      toe_off: when it leaves the floor.
      other: the other leg's touch-down in between.
      double_support: share of the cycle with both feet on the floor.
    """

    side: int
    start: int
    stop: int
    toe_off: int
    other: int
    double_support: float

    @property
    def ticks(self) -> int:
        """How long it lasts, in ticks."""
        return self.stop - self.start

    @property
    def stance_share(self) -> float:
        """Share of the cycle from touch-down to toe-off."""
        return (self.toe_off - self.start) / self.ticks


def settled(contact: Bool[np.ndarray, "T"], shortest: int) -> Bool[np.ndarray, "T"]:
    """Contact without bounces: first gaps, then contacts of less than ``shortest`` ticks are filled in.

    What touches an end of the recording is left, nobody knows how long it is.
    """
    found = contact.copy()
    for state in (False, True):
        edges = np.flatnonzero(np.diff(found)) + 1
        for start, stop in pairwise(edges):
            if found[start] == state and stop - start < shortest:
                found[start:stop] = not state
    return found


def cycles(contact: Bool[np.ndarray, "T 2"]) -> tuple[list[Cycle], int]:
    """All whole cycles of both legs, and how many more were left out.

    Args:
      contact: of the left and right sole, `settled`.

    Returns:
      The cycles in which the legs took turns: one touch-down of the other leg, one toe-off of
      their own; and the number of those in which they did not.
    """
    landings = [np.flatnonzero(contact[1:, side] & ~contact[:-1, side]) + 1 for side in (0, 1)]
    found, odd = [], 0
    both = contact[:, 0] & contact[:, 1]
    for side in (0, 1):
        others = landings[1 - side]
        for start, stop in pairwise(landings[side]):
            between = others[(others > start) & (others < stop)]
            if len(between) != 1:
                odd += 1
                continue
            off = int(start + np.argmin(contact[start:stop, side]))
            share = float(both[start:stop].mean())
            found.append(Cycle(side, int(start), int(stop), off, int(between[0]), share))
    return found, odd


def normalised(signal: Float[np.ndarray, "T *Q"], cycle: Cycle) -> Float[np.ndarray, "P *Q"]:
    """[POINTS] the signal over the cycle, 0 to 100 per cent, linear between ticks."""
    place = cycle.start + np.linspace(0.0, cycle.ticks, POINTS)
    low = np.minimum(place.astype(int), len(signal) - 2)
    share = (place - low).reshape(-1, *[1] * (signal.ndim - 1))
    return (1 - share) * signal[low] + share * signal[low + 1]
