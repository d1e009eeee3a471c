"""``sensitivity.png``: speed, survival and thresholds over each setting."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

from jaxwalk.common import figures
from jaxwalk.measure import one_change

_LABELS = {  # and the unit that its values are shown in
    "timestep": ("time step, ms", 1e-3),
    "iterations": ("solver iterations", 1),
    "contact_timeconst": ("contact time constant, ms", 1e-3),
    "friction": ("friction", 1),
}
_FIRST: dict[str, Any] = {"color": one_change.BLUE, "marker": "o"}
_SECOND: dict[str, Any] = {"color": one_change.ORANGE, "marker": "s"}
_SHARES = (
    ("never_fell", "never fell, unpushed", _FIRST),
    ("pushes_survived", "pushes survived", _SECOND),
)
_WAYS = (("forward", _FIRST), ("backward", _SECOND))


def draw(result: dict[str, Any], title: str) -> Figure:
    """A column for each setting; a grey line marks the policy's own value.

    Args:
      result: of ``sensitivity``.
    """
    figure = figures.new_figure(3.3 * len(_LABELS), 7.2)
    panels = figure.subplots(3, len(_LABELS), sharex="col", sharey="row")
    for column, (parameter, (label, unit)) in enumerate(_LABELS.items()):
        rows = [row for row in result["rows"] if row["parameter"] == parameter]
        speed, survival, threshold = panels[:, column]
        one_change.speed(speed, rows)
        for name, told, style in _SHARES:
            one_change.survival(survival, rows, name, label=told, **style)
        for way, style in _WAYS:
            one_change.threshold(threshold, rows, way, label=way, **style)
        own = next(row["value"] for row in rows if row["own"])
        for axes in panels[:, column]:
            one_change.prepare(axes, own)
        threshold.set_xlabel(label)
        threshold.set_xticks([row["value"] for row in rows], [f"{row['value'] / unit:g}" for row in rows])
    panels[0, 0].set_ylabel("speed, m/s\n(bar: between walkers)")
    panels[1, 0].set_ylabel("share\n(bar: 95 % interval)")
    panels[2, 0].set_ylabel("threshold, N s")
    panels[2, 0].set_ylim(bottom=0, top=1.08 * panels[2, 0].get_ylim()[1])
    for axes in panels[1:, 0]:
        axes.legend(frameon=False, fontsize=8, loc="lower left")
    figure.suptitle(f"{title} (grey: its own)", fontsize=11, x=0.01, ha="left")
    return figure
