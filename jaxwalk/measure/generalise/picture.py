"""``generalise.png``: speed, survival and thresholds in each kind of circumstance."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.lines import Line2D

from jaxwalk.common import figures
from jaxwalk.measure import one_change
from jaxwalk.measure.one_change import Rows

LABELS = {
    "stature": "stature, m",
    "mass": "mass, kg",
    "backpack": "backpack, kg",
    "front_pack": "front pack, kg",
    "force": "steady force, N",
    "friction": "friction",
    "slope": "slope, degrees",
    "delay": "delay, s",
    "motor_strength": "motors' strength",
    "noise": "sensor noise",
    "speed": "speed asked for, m/s",
}
_ACROSS = 4  # kinds side by side
_COLOURS = (one_change.BLUE, one_change.ORANGE)  # of the policy, and of the one beside it
_SHARES: tuple[tuple[str, str, dict[str, Any]], ...] = (  # of `one_change.measured`: label and looks
    ("never_fell", "never fell, unpushed", {"marker": "o", "linestyle": "-"}),
    ("pushes_survived", "pushes survived", {"marker": "s", "linestyle": "--"}),
)
# Wide open marks beneath small full ones: where two policies do alike, both are seen.
_FIRST, _BESIDE = {"zorder": 3}, {"zorder": 2, "markerfacecolor": "white", "markersize": 9, "linewidth": 1.2}


def draw(result: dict[str, Any]) -> Figure:
    """Three panels for each kind: speed, shares, thresholds; a grey line marks the policy's own value.

    Args:
      result: of ``generalise``.
    """
    rows = result["rows"]
    kinds = list(dict.fromkeys(row["kind"] for row in rows))
    bands = [kinds[at : at + _ACROSS] for at in range(0, len(kinds), _ACROSS)]
    across = max(map(len, bands))
    figure = figures.new_figure(max(6.5, 1.0 + 3.1 * across), 0.9 + 5.6 * len(bands))
    names = list(dict.fromkeys(row["policy"] for row in rows))
    parts = figure.subfigures(len(bands), 1, squeeze=False)[:, 0]
    for part, band in zip(parts, bands, strict=True):
        _band(part, band, across, rows, names)
    figure.suptitle(
        f"{result['policy']}, frozen, in other circumstances (grey: its own)",
        fontsize=11, x=0.01, ha="left",
    )  # fmt: skip
    figure.legend(handles=_legend(names), loc="outside lower left", ncols=len(names) + 2, frameon=False)
    return figure


def _band(part: SubFigure, kinds: list[str], across: int, rows: Rows, names: list[str]) -> None:
    panels = part.subplots(3, across, sharex="col", sharey="row", squeeze=False)
    for axes in panels[:, len(kinds) :].flat:
        axes.remove()
    for column, kind in enumerate(kinds):
        here = [row for row in rows if row["kind"] == kind]
        own = next(row["value"] for row in here if row["own"])
        for axes in panels[:, column]:
            one_change.prepare(axes, own)
        for name, colour in zip(names, _COLOURS, strict=False):
            one = [row for row in here if row["policy"] == name]
            _policy(panels[:, column], one, {"color": colour, **(_look(name, names))})
        if kind == "speed":
            panels[0, column].axline((own, own), slope=1, color="0.6", linestyle=":", zorder=0)
            panels[0, column].annotate("as asked", (own, own), xytext=(4, -12), textcoords="offset points",
                                       color="0.4", fontsize=8)  # fmt: skip
        panels[2, column].axhline(0, color="0.5", linewidth=0.8)
        panels[2, column].set_xlabel(LABELS[kind])
        values = sorted({row["value"] for row in here})
        panels[2, column].set_xticks(values, [f"{value:g}" for value in values])
        panels[2, column].margins(x=0.08)
    panels[0, 0].set_ylabel("speed, m/s\n(bar: walkers)")
    panels[1, 0].set_ylabel("share\n(bar: 95 %)")
    panels[2, 0].set_ylabel("threshold, N s\nback | forth")


def _policy(panels: Any, rows: Rows, look: dict[str, Any]) -> None:
    look = {"markersize": 4.5, **look}
    one_change.speed(panels[0], rows, **look)
    for name, _, style in _SHARES:
        one_change.survival(panels[1], rows, name, **look, **style)
    axes: Axes = panels[2]
    for way, sign in (("forward", 1), ("backward", -1)):
        one_change.threshold(axes, rows, way, sign, marker="o", **look)


def _look(name: str, names: list[str]) -> dict[str, Any]:
    return _FIRST if name == names[0] else _BESIDE


def _legend(names: list[str]) -> list[Line2D]:
    policies = [
        Line2D([], [], color=colour, marker="o", label=name, **_look(name, names))
        for name, colour in zip(names, _COLOURS, strict=False)
    ]
    return policies + [Line2D([], [], color="0.3", label=label, **style) for _, label, style in _SHARES]
