"""``jaxwalk refine``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from jaxwalk.common import files
from jaxwalk.common.errors import UserError
from jaxwalk.options import checks
from jaxwalk.options.parse import Policy, reader


@dataclass(frozen=True)
class RefineArgs:
    """Search on from a trained policy: its last layer, by an evolution strategy, under the graded pushes that
    training's evaluations rank by."""

    policy: Policy
    out: Path
    """File for the policy, .safetensors; the one that was given, where nothing better is found."""
    generations: int = 30
    """How often all candidates walk."""
    candidates: int = 24
    """Policies of a generation."""
    sigma: float = 0.02
    """First step size of the search, in units of the last layer's numbers."""
    seed: int = 0
    """Seed of candidates, starts and noise."""

    def check(self) -> None:
        """As `Options.check`."""
        checks.policy(self.policy)
        checks.between("--generations", self.generations, 1, 10_000, "")
        checks.between("--candidates", self.candidates, 4, 10_000, "")
        checks.between("--sigma", self.sigma, 1e-6, 10.0, "")
        checks.seed(self.seed)
        if self.out.suffix != ".safetensors":
            raise UserError(f"--out {self.out}: give a file that ends in .safetensors")
        files.check_output("--out", self.out)


read = reader(RefineArgs, "refine")
