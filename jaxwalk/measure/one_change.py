"""One policy under many conditions: what is told of each, in tables and in panels.

A row is what `measured` gives, with the ``value`` of what was changed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from jaxwalk.measure.protocol import PushTest
from jaxwalk.measure.survival import pooled

BLUE, ORANGE = "#2f6db5", "#d9742b"
Rows = Sequence[dict[str, Any]]


def measured(found: dict[str, Any], test: PushTest) -> dict[str, Any]:
    """A row of an evaluation's results: walking, survival unpushed and pushed with intervals, thresholds."""
    walking, shares = found["walking"], np.asarray(found["pushes"]["survival"])
    survivors = round(float(shares.sum()) * test.cell)
    return {
        "walking": walking,
        "never_fell": pooled(round(walking["survival"] * test.walkers), test.walkers),
        "pushes_survived": pooled(survivors, shares.size * test.cell),
        "impulses": found["pushes"]["impulses"],
        "threshold": found["threshold"],
    }


COLUMNS = ("up", "m/s", "m/step", "pushed, up", "+ / - N s")


def cells(row: dict[str, Any]) -> tuple[str, ...]:
    """A row on the terminal, under `COLUMNS`."""
    walking, pushes = row["walking"], row["pushes_survived"]
    return (
        f"{row['never_fell']['share']:.3f}",
        f"{walking['speed_mean']:.3f}",
        f"{walking['step_length_mean']:.3f}",
        f"{pushes['share']:.2f} ({pushes['low']:.2f}-{pushes['high']:.2f})",
        " / ".join(_size(row, way, sign) for way, sign in (("forward", 1), ("backward", -1))),
    )


def _size(row: dict[str, Any], way: str, sign: int) -> str:
    """A threshold, N s, as text; + where it is the largest impulse that was tried."""
    size = row["threshold"][way]
    if size is None:
        return "-"
    ends = size > 0 and math.isclose(size, max(sign * impulse for impulse in row["impulses"]))
    return f"{size:.3g}{'+' if ends else ''}"


def prepare(axes: Axes, own: int | float) -> None:
    """Lay out a panel; a grey line marks the policy's own value."""
    axes.axvline(own, color="0.85", linewidth=4, zorder=0)
    axes.grid(axis="y", color="0.92")
    axes.spines[["top", "right"]].set_visible(False)


def values(rows: Rows) -> list[int | float]:
    """The value of what was changed, row by row."""
    return [row["value"] for row in rows]


def speed(axes: Axes, rows: Rows, **style: Any) -> None:
    """Speed, m/s; a bar is the spread between walkers."""
    walking = [row["walking"] for row in rows]
    axes.errorbar(
        values(rows), [w["speed_mean"] for w in walking], [w["speed_std"] for w in walking],
        **{"marker": "o", "color": BLUE, "capsize": 3, **style},
    )  # fmt: skip


def survival(axes: Axes, rows: Rows, name: str, **style: Any) -> None:
    """The share called ``name`` of `measured`, with its interval."""
    share, low, high = (np.array([row[name][key] for row in rows]) for key in ("share", "low", "high"))
    axes.errorbar(values(rows), share, [share - low, high - share], **{"capsize": 3, **style})
    axes.set_ylim(-0.04, 1.06)


def threshold(axes: Axes, rows: Rows, way: str, sign: int = 1, **style: Any) -> None:
    """The threshold of one way, N s, multiplied by ``sign``; nothing where none was tried."""
    sizes = [np.nan if row["threshold"][way] is None else sign * row["threshold"][way] for row in rows]
    axes.plot(values(rows), sizes, **style)
