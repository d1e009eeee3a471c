"""``jaxwalk report``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

from jaxwalk.common import files
from jaxwalk.common.errors import UserError
from jaxwalk.options import checks
from jaxwalk.options.parse import OptionalFile, Policy, reader

Name = Literal["compare", "evaluate", "push-map", "generalise", "sensitivity", "agreement", "gait", "bench"]
"""Parts of the report, in their order on the page: each is the command of that name."""


@dataclass(frozen=True)
class ReportArgs:
    """All of a policy's results as one HTML page that stands alone.

    Each part is a command's results in its own folder of --results: map.json and map.png in
    RESULTS/push-map, and so on. What is there and of this very policy is used; what is missing is measured
    now and kept there, so that an interrupted report goes on. All parts take most of an hour on two cores.
    """

    policy: Policy
    out: Path
    """File for the page, replaced if there; .html."""
    results: OptionalFile = None
    """Folder of the results. Default: --out without its .html."""
    parts: tuple[Name, ...] = get_args(Name)
    """What to show, with spaces between."""
    quick: bool = False
    """Measure what is missing with small samples, in minutes; the page says so."""
    seed: int = 0
    """Seed of what is measured now."""

    @property
    def folder(self) -> Path:
        """The folder of the results."""
        return self.out.with_suffix("") if self.results is None else self.results

    def check(self) -> None:
        """As `Options.check`."""
        checks.policy(self.policy)
        if self.out.suffix.lower() not in (".html", ".htm"):
            raise UserError(f"--out {self.out}: give a file that ends in .html")
        files.check_output("--out", self.out)
        files.check_folder("--out" if self.results is None else "--results", self.folder)
        if not self.parts or len(set(self.parts)) < len(self.parts):
            raise UserError(f"--parts {' '.join(self.parts)}: give one or more, each once")
        checks.seed(self.seed)


read = reader(ReportArgs, "report")
