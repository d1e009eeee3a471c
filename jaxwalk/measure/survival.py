"""What counts of survivors say: intervals and thresholds."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

SURVIVED = 0.95  # share that makes an impulse one that is survived


def wilson(
    survivors: NDArray[np.integer], trials: int, confidence: float = 0.95
) -> tuple[NDArray[np.floating], NDArray[np.floating]]:
    """Least and greatest share of survivors that the counts are consistent with (Wilson 1927).

    Args:
      survivors: of ``trials``, any shape.
    """
    z = norm.ppf(0.5 + confidence / 2)
    share = survivors / trials
    centre = (share + z**2 / (2 * trials)) / (1 + z**2 / trials)
    half = z / (1 + z**2 / trials) * np.sqrt(share * (1 - share) / trials + z**2 / (4 * trials**2))
    # Rounding must not put an end on the wrong side of the share itself.
    return np.clip(centre - half, 0.0, share), np.clip(centre + half, share, 1.0)


def pooled(survivors: int, trials: int) -> dict[str, int | float]:
    """One count as a share with its interval (Wilson, 95 %)."""
    low, high = wilson(np.asarray([survivors]), trials)
    share = survivors / trials
    return {
        "survivors": survivors,
        "trials": trials,
        "share": share,
        "low": float(low[0]),
        "high": float(high[0]),
    }


def threshold(impulses: Sequence[float], survival: Sequence[float]) -> dict[str, float | None]:
    """Largest impulse of each direction such that it and all smaller ones are survived by 95 %.

    Args:
      impulses: the grid, N s, signed. survival: of each, over phases and replicas.

    Returns:
      forward and backward, N s, as magnitudes; 0 where even the smallest was not survived, None where
      none was tried.
    """
    found: dict[str, float | None] = {}
    for name, sign in (("forward", 1), ("backward", -1)):
        tried = sorted((sign * i, s) for i, s in zip(impulses, survival, strict=True) if sign * i > 0)
        found[name] = 0.0 if tried else None
        for size, share in tried:
            if share < SURVIVED:
                break
            found[name] = size
    return found


def each_phase(
    impulses: Sequence[float], survival: Sequence[Sequence[float]]
) -> list[dict[str, float | None]]:
    """[P] the `threshold` of each phase of the step.

    Args:
      survival: [I][P] share of each impulse and phase.
    """
    return [threshold(impulses, column) for column in zip(*survival, strict=True)]


def worst_phase(found: Sequence[dict[str, float | None]]) -> dict[str, float | None]:
    """The smallest threshold of all phases, each way; None where none was tried."""
    ways = found[0] if found else ()
    each = {way: [size for one in found if (size := one[way]) is not None] for way in ways}
    return {way: min(sizes, default=None) for way, sizes in each.items()}
