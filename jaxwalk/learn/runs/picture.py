"""``training.png``: how a run learned, at a glance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import EngFormatter

from jaxwalk.common.figures import new_figure, write_png

_BLUE, _ORANGE = "#2f6db5", "#d9742b"
_DOTS = 25  # points fewer than these are few enough to mark

# One panel each: title, unit of the ordinate, [(metric, label, colour)].
_PANELS = (
    ("Reward of a footstep", "", [("train/reward", "", _BLUE)]),
    (
        "Return from a footstep on",
        "",
        [
            ("train/predicted_return", "predicted by the critic", _ORANGE),
            ("train/real_return", "real", _BLUE),
        ],
    ),
    ("Falls", "per 100 footsteps", [("train/falls_per_100", "", _BLUE)]),
    ("Forward speed", "m/s", [("train/speed", "training", _BLUE), ("eval/speed", "evaluation", _ORANGE)]),
    ("Survival in evaluation", "share of walkers", [("eval/survival", "", _ORANGE)]),
    (
        "Footstep",
        "m, s",
        [("train/step_length", "length, m", _BLUE), ("train/step_duration", "duration, s", _ORANGE)],
    ),
)


def training_png(metrics_rows: Sequence[Mapping[str, Any]], path: Path) -> None:
    """Draw the curves of one run.

    Args:
      metrics_rows: as read from ``metrics.jsonl``; a metric may be missing or null in any row.
      path: PNG file, replaced if there.
    """
    figure = new_figure(12.0, 6.4)
    panels = figure.subplots(2, 3, sharex=True)
    for axes, (title, unit, curves) in zip(panels.flat, _PANELS, strict=True):
        axes.set_title(title, loc="left", fontsize=11, fontweight="bold")
        axes.set_ylabel(unit)
        axes.grid(color="0.92")
        axes.spines[["top", "right"]].set_visible(False)
        for name, label, colour in curves:
            _curve(axes, metrics_rows, name, label, colour)
        if axes.get_legend_handles_labels()[1]:
            axes.legend(frameon=False, fontsize=9)
    falls, survival = panels.flat[2], panels.flat[4]
    falls.set_ylim(bottom=0)
    survival.set_ylim(-0.02, 1.02)
    for axes in panels[1]:
        axes.set_xlabel("footsteps")
        axes.xaxis.set_major_formatter(EngFormatter(sep=""))
    write_png(figure, path)


def _curve(axes: Axes, rows: Sequence[Mapping[str, Any]], name: str, label: str, colour: str) -> None:
    points = [(row["footsteps"], row[name]) for row in rows if row.get(name) is not None]
    if not points:
        return
    x, y = np.asarray(points, dtype=float).T
    marker = "o" if len(x) < _DOTS else ""
    axes.plot(x, y, color=colour, label=label or None, linewidth=1.6, marker=marker, markersize=3.5)
