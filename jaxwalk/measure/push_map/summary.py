"""What a finished map says: survival with its intervals, thresholds, and the limits beside them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from jaxwalk.measure.push_map import capturability
from jaxwalk.measure.push_map.capturability import Pendulum
from jaxwalk.measure.push_map.grid import Grid
from jaxwalk.measure.push_map.table import Table
from jaxwalk.measure.survival import each_phase, threshold, wilson, worst_phase
from jaxwalk.model.push_points import Point

QUANTILE = 0.95  # of survivors' longest and shortest steps: a single odd step is nobody's ability


def summarise(table: Table, pendulum: Pendulum) -> dict[str, Any]:
    """All of ``map.json`` that comes from the trials.

    Every part is [durations][points] of its own: survival, low, high (Wilson, 95 %) and recovery
    [I][P], thresholds over all phases, for the worst phase and for each, in N s and N s/kg.
    The pendulum's limits are those of pushes on the torso: it takes all of an impulse into its
    mass, where a leg hands part of it to the ground or swings on with it. Other points have none.
    """
    grid = table.grid
    survived = table.columns["survived"].reshape(grid.shape)
    recovery = table.columns["recovery_seconds"].reshape(grid.shape)
    parts = [
        [
            _part(grid, survived[d, p], recovery[d, p], pendulum, Point.of(point).on_torso)
            for p, point in enumerate(grid.points)
        ]
        for d in range(len(grid.durations))
    ]
    up = table.columns["survived"]  # who falls may do so before the push is over
    delivered, asked = table.columns["impulse_delivered"][up], grid.columns()["impulse"][up]
    return {
        "impulses": list(grid.impulses),
        "phases": list(grid.phases),
        "points": list(grid.points),
        "durations": list(grid.durations),
        "replicas": grid.replicas,
        "trials": grid.size,
        "impulse_delivered_error": float(np.max(np.abs(delivered - asked), initial=0.0)),
        "pendulum": {
            "height": pendulum.height,
            "mass": pendulum.mass,
            "step": pendulum.step,
            "seconds": pendulum.seconds,
            "longest": pendulum.longest,
            "shortest": pendulum.shortest,
            "half_foot": pendulum.half_foot,
            "omega": pendulum.omega,
            "capture_distance": [capturability.capture_distance(pendulum, n) for n in range(5)]
            + [capturability.capture_distance(pendulum)],
        },
        "maps": parts,
    }


def _part(
    grid: Grid,
    survived: NDArray[np.bool_],
    recovery: NDArray[np.floating],
    pendulum: Pendulum,
    limited: bool,
) -> dict[str, Any]:
    """One duration and point; ``survived`` and ``recovery`` are [I, P, replicas].

    Args:
      limited: the pendulum's limits hold for pushes there.
    """
    shares = survived.mean(2)
    low, high = wilson(survived.sum(2), grid.replicas)
    steady = np.isfinite(recovery)
    mean_recovery = np.where(steady, recovery, 0.0).sum(2) / np.maximum(steady.sum(2), 1)
    each = each_phase(grid.impulses, shares.tolist())
    worst = worst_phase(each)
    limits = _limits(grid, pendulum) if limited else None
    return {
        "survival": shares.tolist(),
        "low": low.tolist(),
        "high": high.tolist(),
        "recovery_seconds": np.where(steady.any(2), mean_recovery, np.nan).tolist(),
        "threshold": {
            "all_phases": _told(
                grid, threshold(grid.impulses, survived.mean((1, 2)).tolist()), pendulum.mass
            ),
            "worst_phase": _told(grid, worst, pendulum.mass),
            "each_phase": [_told(grid, one, pendulum.mass) for one in each],
        },
        "limits": limits and {name: curve.tolist() for name, curve in limits.items()},
        "share_of_limit": limits
        and {
            way: [_share(one[way], limit) for one, limit in zip(each, limits[name], strict=True)]
            for way, name in (("forward", "B"), ("backward", "C"))
        },
    }


def _limits(grid: Grid, pendulum: Pendulum) -> dict[str, NDArray[np.floating]]:
    time = np.asarray(grid.phases) * pendulum.seconds
    return {
        "A": np.asarray(capturability.forward_fixed(pendulum, time)),
        "B": np.asarray(capturability.forward_replanned(pendulum, time)),
        "C": np.asarray(capturability.backward(pendulum, time)),
    }


def _share(size: float | None, limit: float) -> float | None:
    """``size`` as a share of the pendulum's limit; None where nothing was tried or the limit is 0."""
    return None if size is None or limit <= 0 else float(size / limit)


def _told(grid: Grid, found: dict[str, float | None], mass: float) -> dict[str, Any]:
    """Thresholds, N s and N s/kg; None: nothing tried. Censored: the grid ended before the walker did."""
    ends = {"forward": max(grid.impulses), "backward": -min(grid.impulses)}
    return {
        way: None
        if size is None
        else {"impulse": size, "per_kg": size / mass, "censored": 0 < size >= ends[way]}
        for way, size in found.items()
    }


def abilities(table: Table) -> tuple[float, float]:
    """Longest step (m) and shortest step time (s) that survivors answered pushes from behind with.

    Those on the torso: a leg that is pushed itself lands where the push takes it. After a push from the
    front a foot is put down again at once in a step back, which says nothing of steps ahead.
    """
    torso = np.array([Point.of(name).on_torso for name in table.grid.points])
    asked = np.broadcast_to(torso[:, None, None, None], table.grid.shape).ravel()
    asked = asked & (table.grid.columns()["impulse"] > 0)
    up = asked & table.columns["survived"] & np.isfinite(table.columns["shortest"])
    if not up.any():
        return 0.0, 0.0
    longest = np.quantile(table.columns["longest"][up], QUANTILE)
    return float(longest), float(np.quantile(table.columns["shortest"][up], 1 - QUANTILE))
