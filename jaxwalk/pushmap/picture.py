"""``map.png``: survival by phase and impulse, thresholds and the pendulum's limits drawn on it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from jaxwalk import plots

_LINES = {  # of the limits: sign, label, style
    "A": (1, "A: step in flight fixed", (0, (1, 1))),
    "B": (1, "B: re-planned at once", (0, (5, 2))),
    "C": (-1, "C: no step back", (0, (3, 1, 1, 1))),
}


def draw(result: dict[str, Any], title: str, path: Path) -> None:
    """One panel for each duration and height.

    Args:
      result: of ``summarise``.
      path: PNG file, replaced if there.
    """
    rows, columns = len(result["durations"]), len(result["heights"])
    figure = plots.new_figure(1.6 + 5.2 * columns, 1.0 + 4.6 * rows)
    panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    image = None
    for d, duration in enumerate(result["durations"]):
        for h, height in enumerate(result["heights"]):
            axes = panels[d, h]
            image = _panel(axes, result, result["maps"][d][h])
            axes.set_title(f"{duration:g} s, {height:+g} m from the torso's centre", loc="left", fontsize=10)
    for axes in panels[-1]:
        axes.set_xlabel("phase of the step at which the push begins")
    for axes in panels[:, 0]:
        axes.set_ylabel("impulse, N s (forward positive)")
    panels[0, 0].legend(fontsize=7, loc="center right", framealpha=0.9)
    figure.colorbar(image, ax=panels, label="share that survives", shrink=0.8)
    figure.suptitle(title, fontsize=11, x=0.01, ha="left")
    plots.write_png(figure, path)


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
    for name, (sign, label, style) in _LINES.items():
        axes.plot(
            phases, sign * np.asarray(part["limits"][name]), color="#1f3f8f", linestyle=style, label=label
        )
    axes.set_ylim(low, high)
    return image


def edges(centres: np.ndarray) -> np.ndarray:
    """[n + 1] borders between and around ``centres``."""
    if len(centres) == 1:
        return np.array([centres[0] - 0.5, centres[0] + 0.5])
    middle = (centres[1:] + centres[:-1]) / 2
    first, last = 2 * centres[0] - middle[0], 2 * centres[-1] - middle[-1]
    return np.concatenate([[first], middle, [last]])
