"""``compare.png``: worst-phase thresholds with their spread, and survival against impulse."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jaxwalk.common import figures
from jaxwalk.measure.compare.verdicts import WAYS, ends
from jaxwalk.measure.survival import SURVIVED

# Okabe & Ito's colours, less yellow: told apart by colour-blind eyes; markers and dashes serve grey paper.
_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000")
_TITLE: dict[str, Any] = {"loc": "left", "fontsize": 10.5, "fontweight": "bold"}
_MARKERS = "osD^vPX"
_DASHES = ("-", (0, (5, 1.5)), (0, (1, 1)), (0, (3, 1, 1, 1)))


def draw(result: dict[str, Any]) -> Figure:
    """Both panels.

    Args:
      result: of ``compare``.
    """
    policies = result["policies"]
    figure = figures.new_figure(12.0, 2.2 + max(2.6, 0.42 * len(policies)))
    left, right = figure.subplots(1, 2, width_ratios=(1, 1.25))
    _thresholds(left, result)
    _survival(right, result)
    for axes in (left, right):
        axes.set_xlabel("impulse, N s (forward positive)")
        axes.spines[["top", "right"]].set_visible(False)
        axes.axvline(0, color="0.4", linewidth=0.8)
    figure.legend(*right.get_legend_handles_labels(), loc="outside lower center", ncols=min(5, len(policies)),
                  frameon=False, fontsize=9)  # fmt: skip
    return figure


def _style(i: int) -> dict[str, Any]:
    return {"color": _COLOURS[i % len(_COLOURS)], "marker": _MARKERS[i % len(_MARKERS)]}


def _thresholds(axes: Axes, result: dict[str, Any]) -> None:
    policies = result["policies"]
    for i, policy in enumerate(policies):
        for way, sign in zip(WAYS, (1, -1), strict=True):
            over = policy["spread"][f"worst_phase_{way}"]
            if over["mean"] is None:
                continue
            seeds = [member["figures"][f"worst_phase_{way}"] for member in policy["members"]]
            colour = _style(i)["color"]
            axes.barh(i, sign * over["mean"], height=0.62, color=colour, alpha=0.3)
            axes.plot([sign * over["min"], sign * over["max"]], [i, i], color=colour, linewidth=2.2)
            axes.scatter([sign * x for x in seeds], [i] * len(seeds), s=26, zorder=3, **_style(i))
            more = "+" if ends(over, result["reach"][way]) else ""
            axes.annotate(
                f"{over['mean']:.3g}{more}", (sign * over["max"], i), xytext=(8 * sign, 0),
                textcoords="offset points", va="center", ha="left" if sign > 0 else "right", fontsize=9,
            )  # fmt: skip
    axes.set_yticks(range(len(policies)), [_short(policy["name"]) for policy in policies])
    axes.invert_yaxis()
    axes.margins(x=0.16)
    axes.set_title(f"Survived by {SURVIVED:.0%} at the worst phase of the step", **_TITLE)
    axes.grid(axis="x", color="0.92")
    axes.set_axisbelow(True)


def _survival(axes: Axes, result: dict[str, Any]) -> None:
    impulses = np.asarray(result["impulses"])
    for i, policy in enumerate(result["policies"]):
        over = [policy["spread"][f"survival_{impulse:+g}"] for impulse in result["impulses"]]
        mean, least, most = (np.array([one[what] for one in over]) for what in ("mean", "min", "max"))
        style = _style(i)
        for n, side in enumerate((impulses < 0, impulses > 0)):
            axes.plot(
                impulses[side], mean[side], linestyle=_DASHES[i % len(_DASHES)], linewidth=1.7, markersize=5,
                label=_short(policy["name"]) if n == 1 or not (impulses > 0).any() else None, **style,
            )  # fmt: skip
            axes.fill_between(
                impulses[side], least[side], most[side], color=style["color"], alpha=0.15, linewidth=0
            )
    axes.axhline(SURVIVED, color="0.5", linewidth=0.8, linestyle=":")
    axes.set_ylim(-0.03, 1.03)
    axes.set_ylabel("share that survives, all phases")
    axes.set_title("Survival; bands from the worst to the best seed", **_TITLE)
    axes.grid(color="0.92")


def _short(name: str) -> str:
    """The end of a long path says more than its start."""
    return name if len(name) <= 24 else f"...{name[-21:]}"
