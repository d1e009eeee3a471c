"""Throughput against batch."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from matplotlib.figure import Figure

from jaxwalk.common import figures
from jaxwalk.measure.bench.limits import C_CONVERGED, C_LIMITED
from jaxwalk.measure.bench.rounds import BARE

_LIMITS = {
    C_LIMITED: ("C MuJoCo, as many iterations", "--"),
    C_CONVERGED: ("C MuJoCo, converged", ":"),
}


def on_cpu(result: Mapping[str, Any]) -> bool:
    """Whether ``result`` was measured on a CPU: rates mean little there, ratios are told."""
    return all(name.startswith("cpu") for name in result["hardware"]["devices"])


def curves(result: Mapping[str, Any], absolute: bool) -> dict[str, list[tuple[int, float]]]:
    """(walkers, ticks a second) of each program and of C MuJoCo; batches that were left out are missing.

    Args:
      absolute: or else in units of the bare step's in the smallest batch. As batches are measured one after
        another and C's rate does not depend on them, each rate is then taken as a multiple of C's of the
        same rounds: a machine that others slowed for a while bends no curve.
    """
    rows = [row for row in result["batches"] if "skipped" not in row]
    found: dict[str, list[tuple[int, float]]] = {}
    for row in rows:
        told = {**row["programs"], **{name: row["limits"][name] for name in _LIMITS}}
        unit = 1.0 if absolute else rows[0]["programs"][BARE]["of_c_mujoco"] * _rate(row["limits"][C_LIMITED])
        for name, one in told.items():
            found.setdefault(name, []).append((row["walkers"], _rate(one) / unit))
    return found


def _rate(one: Mapping[str, Any]) -> float:
    return one["physics_steps_per_second"]


def draw(result: Mapping[str, Any]) -> Figure:
    """Ratios on a CPU; on a GPU, where they span decades, rates on a logarithmic axis.

    Args:
      result: of ``jaxwalk bench --batches``.
    """
    absolute = not on_cpu(result)
    figure = figures.new_figure(7.2, 4.8)
    axes = figure.subplots()
    found = curves(result, absolute)
    for name, points in found.items():
        label, line = _LIMITS.get(name, (name.replace("_", " "), "-"))
        grey, marker = ("0.5", "") if name in _LIMITS else (None, "o")
        sizes, rates = zip(*points, strict=True)
        axes.plot(sizes, rates, line, label=label, linewidth=1.6, color=grey, marker=marker, markersize=4)
    axes.set_xscale("log", base=2)
    if absolute:
        axes.set_yscale("log")
    else:
        axes.set_ylim(bottom=0.0)
    sizes = sorted({size for points in found.values() for size, _ in points})
    axes.set_xticks(sizes, [f"{size:,}" for size in sizes])
    axes.set_xlabel("walkers")
    smallest = f"of bare mjx.step with {sizes[0]:,} walkers" if sizes else ""
    axes.set_ylabel("ticks/s" if absolute else f"ticks/s, {smallest}")
    axes.grid(color="0.92", which="both")
    axes.spines[["top", "right"]].set_visible(False)
    if found:
        axes.legend(frameon=False, fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    hardware = ", ".join(dict.fromkeys(result["hardware"]["devices"]))
    versions = f"jax {result['versions']['jax']}, mujoco-mjx {result['versions']['mujoco-mjx']}"
    axes.set_title(f"{hardware}; {versions}", loc="left", fontsize=10)
    return figure
