"""``sensitivity.png``: speed, survival and thresholds over each setting."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from jaxwalk import plots

_LABELS = {  # and the unit that its values are shown in
    "timestep": ("time step, ms", 1e-3),
    "iterations": ("solver iterations", 1),
    "contact_timeconst": ("contact time constant, ms", 1e-3),
    "friction": ("friction", 1),
}
_BLUE, _ORANGE = "#2f6db5", "#d9742b"


def draw(result: dict[str, Any], title: str, path: Path) -> None:
    """A column for each setting; a grey line marks the policy's own value.

    Args:
      result: of ``sensitivity``.
      path: PNG file, replaced if there.
    """
    figure = plots.new_figure(3.3 * len(_LABELS), 7.2)
    panels = figure.subplots(3, len(_LABELS), sharex="col", sharey="row")
    for column, (parameter, (label, unit)) in enumerate(_LABELS.items()):
        rows = [row for row in result["rows"] if row["parameter"] == parameter]
        speed, survival, threshold = panels[:, column]
        _speed(speed, rows)
        _survival(survival, rows)
        _threshold(threshold, rows)
        own = next(row["value"] for row in rows if row["own"])
        for axes in panels[:, column]:
            axes.axvline(own, color="0.8", linewidth=4, zorder=0)
            axes.grid(axis="y", color="0.92")
            axes.spines[["top", "right"]].set_visible(False)
        threshold.set_xlabel(label)
        threshold.set_xticks([row["value"] for row in rows], [f"{row['value'] / unit:g}" for row in rows])
    panels[0, 0].set_ylabel("speed, m/s\n(bar: between walkers)")
    panels[1, 0].set_ylabel("share\n(bar: 95 % interval)")
    panels[2, 0].set_ylabel("threshold, N s")
    panels[2, 0].set_ylim(bottom=0, top=1.08 * panels[2, 0].get_ylim()[1])
    for axes in panels[1:, 0]:
        axes.legend(frameon=False, fontsize=8, loc="lower left")
    figure.suptitle(f"{title} (grey: its own)", fontsize=11, x=0.01, ha="left")
    plots.write_png(figure, path)


def _values(rows: list[dict[str, Any]]) -> list[int | float]:
    return [row["value"] for row in rows]


def _speed(axes: Axes, rows: list[dict[str, Any]]) -> None:
    walking = [row["walking"] for row in rows]
    axes.errorbar(
        _values(rows), [w["speed_mean"] for w in walking], [w["speed_std"] for w in walking],
        marker="o", color=_BLUE, capsize=3,
    )  # fmt: skip


def _survival(axes: Axes, rows: list[dict[str, Any]]) -> None:
    for name, label, colour, marker in (
        ("never_fell", "never fell, unpushed", _BLUE, "o"),
        ("pushes_survived", "pushes survived", _ORANGE, "s"),
    ):
        share, low, high = (np.array([row[name][key] for row in rows]) for key in ("share", "low", "high"))
        axes.errorbar(
            _values(rows), share, [share - low, high - share],
            marker=marker, color=colour, capsize=3, label=label,
        )  # fmt: skip
    axes.set_ylim(-0.03, 1.03)


def _threshold(axes: Axes, rows: list[dict[str, Any]]) -> None:
    for way, colour, marker in (("forward", _BLUE, "o"), ("backward", _ORANGE, "s")):
        sizes = [np.nan if row["threshold"][way] is None else row["threshold"][way] for row in rows]
        axes.plot(_values(rows), sizes, marker=marker, color=colour, label=way)
