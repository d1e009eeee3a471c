"""What several seeds say together: mean and spread, as numbers and as a picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.ticker import EngFormatter

from jaxwalk.common import figures
from jaxwalk.common.files import write_json
from jaxwalk.learn.runs import run_folder, seeds_folder

_MARKS = ("score", "survival", "worst", "calm", "speed")
_TOLD = ("interrupted", "footsteps", "seconds", "best", "finals")  # of a run's summary
_PANELS = (
    ("eval/survival", "Survival in evaluation", "share of walkers"),
    ("eval/score", "Score of the evaluation", ""),
    ("eval/speed", "Forward speed", "m/s"),
)
_BLUE = "#2f6db5"


def conclude(path: Path, failed: Mapping[int, str]) -> None:
    """Write down what came of the seeds, and draw it.

    Args:
      failed: why, for each seed that came to no end.

    Raises:
      UserError: a file of theirs is damaged, or cannot be written.
    """
    runs = []
    for seed in seeds_folder.load(path):
        summary = run_folder.read_summary(seeds_folder.folder(path, seed))
        run = {"seed": seed, "folder": seeds_folder.folder(path, seed).name}
        run |= {name: summary[name] for name in _TOLD if name in summary}
        runs.append(run | ({"failed": failed[seed]} if seed in failed else {}))
    ended = [run for run in runs if "best" in run]
    last = [run["finals"][0] for run in ended if run["finals"]]
    together = {
        "runs": runs,
        "best": spread([run["best"] for run in ended]),
        "finals": spread(last) if len(last) == len(ended) else {},
    }
    write_json(path / seeds_folder.SUMMARY, seeds_folder.read(path) | together)
    rows = {
        seed: run_folder.read_metrics(seeds_folder.folder(path, seed)) for seed in seeds_folder.load(path)
    }
    with figures.spare(print):
        draw(rows, path / seeds_folder.PICTURE)


def spread(marks: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, float | int | None]]:
    """Mean, standard deviation between seeds (n - 1; None of one seed), least and most of each mark."""
    found = {}
    for name in _MARKS if marks else ():
        values = [one[name] for one in marks]
        found[name] = {
            "mean": float(np.mean(values)),
            "std": float(np.std(values, ddof=1)) if len(values) > 1 else None,
            "least": min(values),
            "most": max(values),
            "seeds": len(values),
        }
    return found


def draw(rows: Mapping[int, Sequence[Mapping[str, Any]]], path: Path) -> None:
    """A panel for each quantity: every seed as a thin line, their mean with a band of a standard deviation.

    Seeds are evaluated at footsteps that differ by less than a report; in between, lines are straight.

    Args:
      rows: of each seed's ``metrics.jsonl``.
      path: PNG file, replaced if there.
    """
    figure = figures.new_figure(12.0, 3.8)
    for axes, (name, title, unit) in zip(figure.subplots(1, len(_PANELS)), _PANELS, strict=True):
        axes.set_title(title, loc="left", fontsize=11, fontweight="bold")
        axes.set_ylabel(unit)
        axes.grid(color="0.92")
        axes.spines[["top", "right"]].set_visible(False)
        axes.set_xlabel("footsteps")
        axes.xaxis.set_major_formatter(EngFormatter(sep=""))
        curves = [curve for one in rows.values() if (curve := _curve(one, name)) is not None]
        for x, y in curves:
            axes.plot(x, y, color=_BLUE, alpha=0.3, linewidth=0.9)
        if not curves:
            continue
        # Where all seeds have come to.
        end = min(x[-1] for x, _ in curves)
        grid = np.unique(np.concatenate([x[x <= end] for x, _ in curves]))
        all_of_them = np.array([np.interp(grid, x, y) for x, y in curves])
        mean, std = all_of_them.mean(axis=0), all_of_them.std(axis=0, ddof=min(1, len(curves) - 1))
        axes.fill_between(grid, mean - std, mean + std, color=_BLUE, alpha=0.18, linewidth=0)
        axes.plot(grid, mean, color=_BLUE, linewidth=2.0, label=f"mean of {len(curves)} seeds, ± std")
        if name == "eval/survival":
            axes.set_ylim(-0.02, 1.02)
            axes.legend(frameon=False, fontsize=9)
    figures.write_png(figure, path)


def _curve(rows: Sequence[Mapping[str, Any]], name: str) -> tuple[np.ndarray, np.ndarray] | None:
    # A training that went back is evaluated there again: the later one counts.
    points = {row["footsteps"]: row[name] for row in rows if row.get(name) is not None}
    if not points:
        return None
    x, y = np.array(sorted(points.items()), float).T
    return x, y
