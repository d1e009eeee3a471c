"""What a study found: the best trials on the terminal, all of them as JSON, CSV and picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from optuna.importance import PedAnovaImportanceEvaluator, get_param_importances
from optuna.study import Study
from optuna.trial import FrozenTrial, TrialState
from rich.console import Console
from rich.table import Table

from jaxwalk.common import figures, files
from jaxwalk.learn.policies import provenance
from jaxwalk.learn.sweep import picture, space
from jaxwalk.learn.sweep.space import Dimension

if TYPE_CHECKING:
    from jaxwalk.learn.sweep.options import SweepArgs

_OPTIONS = ("study", "set", "trials", "pruner", "preset", "seed")
BEST = 10  # trials on the terminal
_ENOUGH = 10  # complete trials, before it is said what matters


def write(study: Study, dimensions: Sequence[Dimension], args: SweepArgs, folder: Path) -> None:
    """Replace ``sweep.json``, ``sweep.csv`` and ``sweep.png`` in ``folder``, and print the best.

    Raises:
      UserError: they cannot be written.
    """
    rows = [_row(trial) for trial in study.get_trials(deepcopy=False)]
    best = sorted((row for row in rows if row["state"] == "complete"), key=lambda row: -row["score"])
    weights = importance(study)
    stamp = provenance.stamp("sweep", args, None, args.config)
    told = {
        **stamp,
        "options": {name: stamp["options"][name] for name in _OPTIONS},
        "space": space.to_json(dimensions),
        "states": {state: sum(row["state"] == state for row in rows) for state in _STATES.values()},
        "best": best[:BEST],
        "importance": weights,
        "trials": rows,
    }
    files.write_json(folder / "sweep.json", told)
    if rows:
        names = [one.name for one in dimensions]
        lines = [
            {name: row[name] for name in ("trial", "state", "score", "seconds", "folder", "error")}
            | {name: row["values"].get(name) for name in names}
            for row in rows
        ]
        files.write_bytes(folder / "sweep.csv", files.to_csv(lines))
        with figures.spare(print):
            picture.draw(rows, dimensions, weights, folder / "sweep.png")
    _print(best, dimensions, told["states"], folder)


def importance(study: Study) -> dict[str, float]:
    """Each option's share in what makes trials good (PED-ANOVA, Watanabe et al. 2023); {} of few trials."""
    complete = study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,))
    if len(complete) < _ENOUGH or len({trial.value for trial in complete}) < 2:
        return {}
    return get_param_importances(study, evaluator=PedAnovaImportanceEvaluator())


def shown(value: float | int | str) -> str:
    """An option's value as a table shows it: fractions in four digits."""
    return f"{value:.4g}" if isinstance(value, float) else str(value)


_STATES = {
    TrialState.COMPLETE: "complete",
    TrialState.PRUNED: "pruned",
    TrialState.FAIL: "failed",
    TrialState.RUNNING: "running",
    TrialState.WAITING: "waiting",
}


def _row(trial: FrozenTrial) -> dict[str, Any]:
    return {
        "trial": trial.number,
        "state": _STATES[trial.state],
        "score": trial.value,  # of a pruned one, at its last evaluation
        "seconds": trial.duration.total_seconds() if trial.duration else None,
        "folder": trial.user_attrs.get("folder"),
        "error": trial.user_attrs.get("error"),
        "values": dict(trial.params),
        "evaluations": {str(number): score for number, score in sorted(trial.intermediate_values.items())},
    }


def _print(
    best: Sequence[dict[str, Any]], dimensions: Sequence[Dimension], states: dict[str, int], folder: Path
) -> None:
    table = Table(box=None, header_style="bold")
    for name in ("trial", "score", *(one.name for one in dimensions), "seconds"):
        table.add_column(name, justify="right")
    for row in best[:BEST]:
        values = [shown(row["values"][one.name]) for one in dimensions]
        table.add_row(str(row["trial"]), f"{row['score']:.3f}", *values, f"{row['seconds']:.0f}")
    console = Console(markup=False)
    console.print(table)
    counted = ", ".join(f"{count} {state}" for state, count in states.items() if count)
    console.print(f"trials: {counted or 'none'}; all of them in {folder}/sweep.csv", soft_wrap=True)
