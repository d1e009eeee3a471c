"""``map.png``: survival by phase and impulse, thresholds and the pendulum's limits drawn on it."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jaxwalk.common import figures
from jaxwalk.model.push_points import Point

_WIDE = 4  # panels in a row, at most
_LINES = {  # of the limits: sign, label, style
    "A": (1, "A: step in flight fixed", (0, (1, 1))),
    "B": (1, "B: re-planned at once", (0, (5, 2))),
    "C": (-1, "C: no step back", (0, (3, 1, 1, 1))),
}


def draw(result: dict[str, Any], title: str) -> Figure:
    """One panel for each duration and point; the limits are drawn where they hold, on the torso.

    Args:
      result: of ``summarise``.
    """
    shown = [(d, p) for d in range(len(result["durations"])) for p in range(len(result["points"]))]
    columns = len(result["points"]) if len(result["points"]) <= _WIDE else _WIDE
    rows = -(-len(shown) // columns)
    figure = figures.new_figure(1.6 + 5.2 * columns, 1.0 + 4.6 * rows)
    panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    images: list[Any] = []
    for axes, (d, p) in zip(panels.flat, shown, strict=False):
        images.append(_panel(axes, result, result["maps"][d][p]))
        words = Point.of(result["points"][p]).words
        axes.set_title(f"{result['durations'][d]:g} s, {words}", loc="left", fontsize=10)
    for axes in panels.flat[len(shown) :]:
        axes.set_axis_off()
    for column in range(columns):
        lowest = panels.flat[max(range(column, len(shown), columns))]
        lowest.set_xlabel("phase of the step at which the push begins")
        lowest.tick_params(labelbottom=True)
    for axes in panels[:, 0]:
        axes.set_ylabel("impulse, N s (forward positive)")
    told = max(panels.flat, key=lambda axes: len(axes.get_legend_handles_labels()[1]))
    free = panels.flat[-1] if len(shown) < panels.size else told
    free.legend(*told.get_legend_handles_labels(), fontsize=7, loc="center right", framealpha=0.9)
    figure.colorbar(images[-1], ax=panels, label="share that survives", shrink=0.8)
    figure.suptitle(title, fontsize=11, x=0.01, ha="left")
    return figure


def _panel(axes: Axes, result: dict[str, Any], part: dict[str, Any]) -> Any:
    impulses, phases = np.asarray(result["impulses"]), np.asarray(result["phases"])
    image = axes.pcolormesh(
        edges(phases), edges(impulses), np.asarray(part["survival"]), cmap="RdYlGn", vmin=0, vmax=1
    )
    axes.axhline(0, color="0.3", linewidth=0.6)
    for way, sign in (("forward", 1), ("backward", -1)):
        found = [one[way] for one in part["threshold"]["each_phase"]]
        if None in found:
            continue
        each = [sign * one["impulse"] for one in found]
        axes.step(
            phases, each, where="mid", color="black", linewidth=1.4,
            label="threshold of the phase (95 %)" if sign > 0 else None,
        )  # fmt: skip
    low, high = axes.get_ylim()
    limits = part["limits"] or {}
    for name, (sign, label, style) in _LINES.items():
        if name in limits:
            curve = sign * np.asarray(limits[name])
            axes.plot(phases, curve, color="#1f3f8f", linestyle=style, label=label)
    axes.set_ylim(low, high)
    return image


def edges(centres: np.ndarray) -> np.ndarray:
    """[n + 1] borders between and around ``centres``."""
    if len(centres) == 1:
        return np.array([centres[0] - 0.5, centres[0] + 0.5])
    middle = (centres[1:] + centres[:-1]) / 2
    first, last = 2 * centres[0] - middle[0], 2 * centres[-1] - middle[-1]
    return np.concatenate([[first], middle, [last]])
