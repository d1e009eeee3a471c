"""What two evaluations of the same trials, one by each engine, have in common."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from jaxwalk.measure.survival import pooled, wilson

WALKING = (
    "survival",
    "speed_mean",
    "step_length_mean",
    "step_duration_mean",
    "torso_pitch_mean",
    "torso_pitch_amplitude",
)


def compare(first: dict[str, Any], second: dict[str, Any], walkers: int, replicas: int) -> dict[str, Any]:
    """Differences are ``second`` less ``first``; intervals are Wilson's, 95 %.

    Args:
      first, second: what `evaluation.evaluate` gave, pushes included, for the same options.
      walkers: that walked unpushed. replicas: walkers for each impulse and phase.

    Returns:
      ``walking``: the difference of each mean, and the standard error of the speed's, which is
      what chance alone makes of it. ``cells``: for each impulse and phase ([I][P]) the intervals of
      both, the difference of the shares, whether the intervals overlap; the share of cells in which they
      do. ``pushes``: survivors of all pushes together, with their intervals.
    """
    walking = {name: second["walking"][name] - first["walking"][name] for name in WALKING}
    spreads = [one["walking"]["speed_std"] for one in (first, second)]
    shares = [np.asarray(one["pushes"]["survival"]) for one in (first, second)]
    survivors = [np.round(share * replicas).astype(int) for share in shares]
    intervals = [wilson(count, replicas) for count in survivors]
    (low, high), (other_low, other_high) = intervals
    overlap = (low <= other_high) & (other_low <= high)
    difference = shares[1] - shares[0]
    trials = replicas * overlap.size
    return {
        "walking": walking | {"speed_standard_error": math.hypot(*spreads) / math.sqrt(walkers)},
        "cells": {
            "impulses": first["pushes"]["impulses"],
            "phases": first["pushes"]["phases"],
            "low": [low.tolist(), other_low.tolist()],
            "high": [high.tolist(), other_high.tolist()],
            "difference": difference.tolist(),
            "overlap": overlap.tolist(),
            "share_overlapping": float(overlap.mean()),
            "largest_difference": float(np.abs(difference).max()),
        },
        "pushes": [pooled(int(count.sum()), trials) for count in survivors],
    }
