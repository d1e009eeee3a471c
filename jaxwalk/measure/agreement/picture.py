"""``agreement.png``: the push maps of both engines side by side, and their difference."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jaxwalk.common import figures
from jaxwalk.measure.push_map.picture import edges


def draw(result: dict[str, Any], title: str) -> Figure:
    """Three maps; where the engines' intervals do not overlap, the third has a cross.

    Args:
      result: of ``agreement``.
    """
    cells = result["cells"]
    phases = np.asarray(cells["phases"])
    figure = figures.new_figure(13.5, 1.8 + 0.36 * len(cells["impulses"]))
    panels = figure.subplots(1, 3, sharex=True, sharey=True)

    def panel(axes: Axes, name: str, values: Any, colours: str, least: float) -> Any:
        axes.set_title(name, loc="left", fontsize=10)
        axes.set_xlabel("phase of the step at which the push begins")
        # Impulses are rows, not a scale: there is nothing between the smallest of either direction.
        rows = np.arange(len(cells["impulses"]) + 1) - 0.5
        return axes.pcolormesh(
            edges(phases), rows, np.asarray(values), cmap=colours, vmin=least, vmax=1, edgecolors="w", lw=0.4
        )

    for axes, (engine, told) in zip(panels, result["engines"].items(), strict=False):
        image = panel(axes, engine, told["pushes"]["survival"], "cividis", 0.0)
    figure.colorbar(image, ax=panels[:2], label="share that survives")
    axes = panels[2]
    first, second = result["engines"]
    apart = panel(axes, f"{second} less {first}", cells["difference"], "PuOr", -1.0)
    figure.colorbar(apart, ax=axes, label="difference of the shares")
    row, column = np.nonzero(~np.asarray(cells["overlap"]))
    axes.plot(
        phases[column], row, "kx", markersize=6, label="95 % intervals do not overlap", linestyle="none"
    )
    if len(row):
        axes.legend(fontsize=8, loc="lower right")
    panels[0].set_yticks(range(len(cells["impulses"])), [f"{i:+g}" for i in cells["impulses"]])
    panels[0].set_ylabel("impulse, N s (forward positive)")
    figure.suptitle(title, fontsize=11, x=0.01, ha="left")
    return figure
