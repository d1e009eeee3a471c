"""``jaxwalk paper``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal, get_args

import tyro

from jaxwalk.common import files
from jaxwalk.common.errors import UserError
from jaxwalk.options import checks
from jaxwalk.options.parse import POLICIES, OptionalFile, reader

Name = Literal[
    "speed", "filters", "pushes", "pitch", "steps", "phases", "trade", "state", "rates", "start", "loads",
    "controllers", "bodies",
]  # fmt: skip
"""Claims, in their order on the page."""
NAMES: tuple[Name, ...] = get_args(Name)


@dataclass(frozen=True)
class PaperArgs:
    """Every claim of Liu et al.'s paper: what it says, what is measured here, and a verdict by a stated rule.

    Claims that are in --out already, of the same policy, options and version, are used again: an interrupted
    measurement goes on. All claims take most of an hour on two cores, with --quick some ten minutes.
    """

    out: Path
    """Folder for paper.md, paper.html, paper.json, and a CSV and a PNG for each claim; replaced if there."""
    policy: Annotated[str, tyro.conf.arg(metavar="POLICY", help=POLICIES)] = "shipped-rigid"
    quick: bool = False
    """Small samples, fewer claims between walls; the page says so."""
    only: tuple[Name, ...] = ()
    """Claims to measure, with spaces between. Default: all."""
    trained: OptionalFile = None
    """Folder with policies and learning curves of the trainings that claims compare. Default: --out."""
    retrain: bool = False
    """Train them all anew first, hours of work, into --trained; run folders are kept in --out/runs."""
    seed: int = 0
    """Seed of all that is drawn at random."""

    @property
    def trainings(self) -> Path:
        """Folder of the trainings."""
        return self.out if self.trained is None else self.trained

    def check(self) -> None:
        """As `Options.check`."""
        checks.policy(self.policy)
        files.check_folder("--out", self.out)
        if self.trained is not None and not self.retrain and not self.trained.is_dir():
            raise UserError(f"--trained {self.trained}: there is no such folder; give one, or --retrain")
        files.check_folder("--out" if self.trained is None else "--trained", self.trainings)
        if len(set(self.only)) < len(self.only):
            raise UserError(f"--only {' '.join(self.only)}: give each claim once")
        checks.seed(self.seed)


read = reader(PaperArgs, "paper")
