"""How long trainings took until their walkers survived a given share of the graded pushes.

python scripts/to_threshold.py RUN [RUN ...] [--survival 0.8,0.9]

Of each run folder, by ``jaxwalk train`` or ``jaxwalk train-baseline``: the first of its evaluations, which
are the same for all, in which no unpushed walker fell and that share of the pushed ones stayed up.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro
from rich.console import Console
from rich.table import Table

from jaxwalk.common.errors import UserError
from jaxwalk.learn.runs import run_folder
from jaxwalk.options.parse import Numbers, parse


@dataclass(frozen=True)
class Args:
    """How long trainings took until their walkers survived a given share of the graded pushes."""

    runs: Annotated[tuple[Path, ...], tyro.conf.Positional]
    """Run folders."""
    survival: Numbers = (0.8, 0.9)
    """Shares to reach."""


def evaluations(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The rows of a run's metrics that tell of one that came to numbers."""
    return [row for row in rows if row.get("eval/survival") is not None]


def first(rows: list[dict[str, Any]], share: float) -> dict[str, Any] | None:
    """The first evaluation that reached ``share``; None: no one did."""
    return next((row for row in rows if row["eval/survival"] >= share and row["eval/calm"] == 1.0), None)


def main(argv: list[str]) -> int:
    try:
        args = parse(Args, argv, "to_threshold")
        read = {run: evaluations(run_folder.read_metrics(run)) for run in args.runs}
    except UserError as error:
        print(f"to_threshold: error: {error}", file=sys.stderr)
        return 2
    table = Table("run", "survived", "footsteps", "seconds")
    for run, rows in read.items():
        most = max((row["eval/survival"] for row in rows), default=0.0)
        for share in args.survival:
            row = first(rows, share)
            told = (
                (f"{row['footsteps']:,}", f"{row['seconds']:,.0f}") if row else (f"never ({most:.0%})", "-")
            )
            table.add_row(str(run), f"{share:.0%}", *told)
    Console().print(table)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
