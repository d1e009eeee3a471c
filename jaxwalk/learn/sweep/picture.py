"""``sweep.png``: the scores in the order of the trials, what mattered, and the score over each option."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from jaxwalk.common import figures
from jaxwalk.learn.sweep.space import Dimension, Range

_BLUE, _ORANGE, _GREY = "#2f6db5", "#d9742b", "0.7"
_COLUMNS = 4


def draw(
    rows: Sequence[Mapping[str, Any]],
    dimensions: Sequence[Dimension],
    importance: Mapping[str, float],
    path: Path,
) -> None:
    """Replace ``path`` by the picture.

    Args:
      rows: of all trials, as in ``sweep.json``; those without a score are left out.
      importance: of the options; may be empty.
    """
    panels = 2 + len(dimensions)
    lines = -(-panels // _COLUMNS)
    figure = figures.new_figure(3.4 * min(panels, _COLUMNS), 3.0 * lines)
    axes = np.atleast_1d(figure.subplots(lines, min(panels, _COLUMNS))).ravel()
    for one in axes:
        one.grid(color="0.92")
        one.spines[["top", "right"]].set_visible(False)
    for one in axes[panels:]:
        one.set_visible(False)
    scored = [row for row in rows if row["score"] is not None]
    _history(axes[0], scored)
    _importance(axes[1], importance)
    for one, dimension in zip(axes[2:], dimensions, strict=False):
        _over(one, scored, dimension)
    figures.write_png(figure, path)


def _history(axes: Axes, rows: Sequence[Mapping[str, Any]]) -> None:
    _titled(axes, "Score by trial", "trial")
    _points(axes, rows, [row["trial"] for row in rows])
    done = [(row["trial"], row["score"]) for row in rows if row["state"] == "complete"]
    if done:
        numbers, scores = zip(*done, strict=True)
        axes.step(numbers, np.maximum.accumulate(scores), where="post", color=_BLUE, linewidth=1.2)
    if axes.get_legend_handles_labels()[1]:
        axes.legend(frameon=False, fontsize=8)


def _importance(axes: Axes, importance: Mapping[str, float]) -> None:
    _titled(axes, "What matters", "share")
    if not importance:
        axes.text(0.5, 0.5, "too few trials to tell", ha="center", transform=axes.transAxes, color="0.5")
        axes.set_xticks([])
        axes.set_yticks([])
        return
    names = sorted(importance, key=lambda name: importance[name])
    axes.barh(names, [importance[name] for name in names], color=_BLUE)


def _over(axes: Axes, rows: Sequence[Mapping[str, Any]], dimension: Dimension) -> None:
    _titled(axes, dimension.name, "")
    held = [row for row in rows if dimension.name in row["values"]]
    values = [row["values"][dimension.name] for row in held]
    if isinstance(dimension, Range):
        _points(axes, held, values)
        if dimension.log:
            axes.set_xscale("log")
        return
    _points(axes, held, [dimension.texts.index(value) for value in values])
    axes.set_xticks(range(len(dimension.texts)), dimension.texts)


def _points(axes: Axes, rows: Sequence[Mapping[str, Any]], x: Sequence[float | int]) -> None:
    for state, colour, marker in (("pruned", _GREY, "x"), ("complete", _ORANGE, "o")):
        mine = [(a, row["score"]) for a, row in zip(x, rows, strict=True) if row["state"] == state]
        if mine:
            axes.scatter(*zip(*mine, strict=True), s=16, color=colour, marker=marker, label=state)


def _titled(axes: Axes, title: str, below: str) -> None:
    axes.set_title(title, loc="left", fontsize=10, fontweight="bold")
    axes.set_xlabel(below, fontsize=9)
    axes.tick_params(labelsize=8)
