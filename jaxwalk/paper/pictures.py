"""What the claims' figures share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter

from jaxwalk.common import figures
from jaxwalk.measure.one_change import BLUE, ORANGE
from jaxwalk.paper.claim import BODIES
from jaxwalk.paper.trainings import TRAININGS

GREEN, GREY = "#3b8a4f", "0.55"
COLOURS = {"planar": BLUE, "walls": ORANGE}  # of the bodies


def panels(
    rows: int, columns: int, width: float = 4.2, height: float = 2.9, **more: Any
) -> tuple[Figure, Any]:
    """A figure and its [rows, columns] panels, ready to draw in."""
    figure = figures.new_figure(width * columns + 0.4, height * rows + 0.3)
    axes = figure.subplots(rows, columns, squeeze=False, **more)
    for one in axes.flat:
        one.grid(color="0.92")
        one.set_axisbelow(True)
        one.spines[["top", "right"]].set_visible(False)
    return figure, axes


def title(axes: Axes, text: str) -> None:
    """Put a heading over the left end of a panel."""
    axes.set_title(text, loc="left", fontsize=10, fontweight="bold")


def bar(axes: Axes, place: float | int, interval: Mapping[str, Any], colour: str, width: float = 0.7) -> None:
    """A mean with its interval, as a bar at ``place``."""
    if interval["mean"] is None:
        return
    axes.bar(place, interval["mean"], width, color=colour, alpha=0.85)
    if interval["low"] is not None:
        down, up = interval["mean"] - interval["low"], interval["high"] - interval["mean"]
        axes.errorbar(
            place, interval["mean"], [[max(down, 0)], [max(up, 0)]], color="0.2", capsize=3, linewidth=1
        )


def point(
    axes: Axes, x: float | int, interval: Mapping[str, Any], colour: str, label: str | None = None
) -> None:
    """A mean with its interval, as a point at ``x``."""
    if interval["mean"] is None:
        return
    down = up = 0.0
    if interval["low"] is not None:
        down, up = interval["mean"] - interval["low"], interval["high"] - interval["mean"]
    axes.errorbar(
        x, interval["mean"], [[max(down, 0.0)], [max(up, 0.0)]], marker="o", markersize=4, color=colour,
        capsize=3, linewidth=1.2, linestyle="none", label=label,
    )  # fmt: skip


def shares(axes: Axes) -> None:
    """Let the ordinate go from 0 to 1, for shares."""
    axes.set_ylim(-0.02, 1.05)


def legend(figure: Figure, axes: Axes) -> None:
    """What the colours of a panel mean, below all panels, where it hides nothing."""
    figure.legend(
        *axes.get_legend_handles_labels(), loc="outside lower left", ncols=3, frameon=False, fontsize=9
    )


def bodies(axes: Any, numbers: Mapping[Any, Any]) -> None:
    """The body's name over each column."""
    for column, body in enumerate(numbers):
        title(axes[0, column], BODIES[body])


def curves(axes: Axes, runs: Mapping[str, Sequence[Mapping[str, Any]]], fixed: Mapping[str, Any]) -> None:
    """Survival in each training's evaluations: mean over seeds, from the least to the most; seeds thin."""
    for (name, seeds), colour in zip(runs.items(), (BLUE, ORANGE, GREEN), strict=False):
        told = [one["curve"] for one in seeds]
        for one in told:
            axes.plot(one["footsteps"], one["survival"], color=colour, linewidth=0.7, alpha=0.6)
        # Seeds are evaluated at footsteps that differ a little: the n-th evaluations belong together.
        count = min(len(one["survival"]) for one in told)
        y = np.array([one["survival"][:count] for one in told])
        x = np.mean([one["footsteps"][:count] for one in told], axis=0)
        axes.plot(
            x, y.mean(0), color=colour, linewidth=2, marker="o", markersize=3, label=TRAININGS[name].words
        )
        axes.fill_between(x, y.min(0), y.max(0), color=colour, alpha=0.15, linewidth=0)
    axes.axhline(fixed["pushed"]["mean"], color=GREY, linestyle="--", linewidth=1, label="step never adapted")
    axes.set_xlabel("footsteps")
    axes.set_ylabel("graded pushes survived, share")
    axes.xaxis.set_major_formatter(EngFormatter(sep=""))
    shares(axes)
    axes.legend(frameon=False, fontsize=8, loc="lower right")
    title(axes, "while they learn (thin: seeds)")


def exams(axes: Axes, runs: Mapping[str, Sequence[Mapping[str, Any]]], fixed: Mapping[str, Any]) -> None:
    """Survival of each kept policy here, with its interval."""
    place, ticks = 0.0, []
    for (name, seeds), colour in zip(runs.items(), (BLUE, ORANGE, GREEN), strict=False):
        for one in seeds:
            bar(axes, place, one["pushed"], colour)
            ticks.append((place, f"{name} {one['seed']}"))
            place += 1.0
        place += 0.5
    bar(axes, place, fixed["pushed"], GREY)
    ticks.append((place, "fixed"))
    axes.set_xticks([x for x, _ in ticks], [text for _, text in ticks], rotation=35, ha="right", fontsize=8)
    axes.set_ylabel("graded pushes survived, share")
    shares(axes)
    title(axes, "policies kept, seed by seed (bar: 95 %)")
