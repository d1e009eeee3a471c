"""``jaxwalk play``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from jaxwalk.common import files
from jaxwalk.common.errors import UserError
from jaxwalk.options import checks, shared
from jaxwalk.options.parse import Policy, reader


@dataclass(frozen=True)
class PlayArgs:
    """Make a page on which a policy's walker walks in the browser, and can be pushed by hand: one file, which
    loads nothing."""

    policy: Policy
    out: Path = Path("jaxwalk-play.html")
    """File for the page, replaced if there; .html."""
    speed: shared.Speed = 1.0
    height: shared.OneStature = None
    mass: shared.OneMass = None
    noise: shared.Noise = 1.0
    open: bool = True
    """Whether it is opened in the browser, where there is one."""

    def check(self) -> None:
        """As `Options.check`."""
        checks.policy(self.policy)
        if self.out.suffix.lower() != ".html":
            raise UserError(f"--out {self.out}: give a file that ends in .html")
        files.check_output("--out", self.out)
        checks.walker(self)


read = reader(PlayArgs, "play")
