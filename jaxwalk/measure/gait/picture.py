"""``gait.png``: every curve over the gait cycle, people's peaks beside it."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jaxwalk.common import figures
from jaxwalk.measure.gait import signals
from jaxwalk.measure.gait.report import SIDES, Report

COLOURS = {"left": "#0072B2", "right": "#D55E00"}  # Okabe and Ito's: told apart by all eyes
DASHES = {"left": "-", "right": (0, (4, 2))}
SIGN = {
    "angle": "flexion +",
    "moment": "extension +",
    "power": "generation +",
    "force": "forward +",
    "pitch": "forward +",
}
TITLES = {"vertical_force": "Vertical ground reaction", "fore_aft_force": "Fore-aft ground reaction"}
ORDER = [f"{joint}_{kind}" for kind in ("angle", "moment", "power") for joint in signals.JOINTS]
ORDER += ["vertical_force", "fore_aft_force", "torso_pitch"]


def draw(report: Report, title: str) -> Figure:
    """Twelve panels on one page."""
    figure = figures.new_figure(10.5, 12.0)
    panels = figure.subplots(4, 3, sharex=True)
    for axes, name in zip(panels.flat, ORDER, strict=True):
        _panel(axes, report, name)
    for axes in panels[-1]:
        axes.set_xlabel("per cent of the gait cycle")
    told = [axes.get_legend_handles_labels() for axes in panels.flat]
    keys = {label: handle for handles, labels in told for handle, label in zip(handles, labels, strict=True)}
    figure.legend(
        list(keys.values()), list(keys), loc="outside lower center", ncols=3, frameon=False, fontsize=9
    )
    figure.suptitle(title, fontsize=12, x=0.01, ha="left")
    return figure


def _panel(axes: Axes, report: Report, name: str) -> None:
    percent = np.arange(len(report.curves[name, "left"].mean))
    stance = report.result["measures"]["stance_share"]
    axes.axvspan(0, stance["mean"], color="0.955", zorder=0, label="mean stance")
    axes.axhline(0, color="0.6", linewidth=0.6, zorder=1)
    for side in SIDES:
        curve, colour = report.curves[name, side], COLOURS[side]
        axes.fill_between(
            percent, curve.mean - curve.sd, curve.mean + curve.sd, color=colour, alpha=0.22, linewidth=0
        )
        label = f"{side}, mean and 1 SD over {report.result['strides'][side]} strides"
        axes.plot(percent, curve.mean, color=colour, linestyle=DASHES[side], linewidth=1.6, label=label)
    _people(axes, report, name)
    joint, _, kind = name.rpartition("_")
    axes.set_title(
        TITLES.get(name, f"{joint} {kind}".capitalize()), loc="left", fontsize=10, fontweight="bold"
    )
    sign = SIGN[kind].replace("flexion", "dorsiflexion") if name == "ankle_angle" else SIGN[kind]
    sign = sign.replace("extension", "plantarflexion") if name == "ankle_moment" else sign
    sign = "upward +" if name == "vertical_force" else sign
    axes.set_ylabel(f"{signals.UNITS[name]}, {sign}", fontsize=9)
    axes.tick_params(labelsize=8)
    axes.set_xlim(0, 100)
    axes.spines[["top", "right"]].set_visible(False)


def _people(axes: Axes, report: Report, name: str) -> None:
    """A point where people's peak is, with one standard deviation where the source tells it."""
    for one in report.people.values():
        if one.curve != name or one.percent is None:
            continue
        spread = None if one.high is None else one.high - one.mean
        axes.errorbar(
            one.percent, one.sign * one.mean, yerr=spread, fmt="o" if spread is None else "D",
            color="black", markersize=4, capsize=2.5, linewidth=1.0, zorder=5,
            label=f"people's peak ({one.source})" + ("" if spread is None else " and 1 SD"),
        )  # fmt: skip
