"""``jaxwalk demo``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from jaxwalk.common import files
from jaxwalk.common.errors import UserError
from jaxwalk.options.parse import reader


@dataclass(frozen=True)
class DemoArgs:
    """Make the page on which the shipped policy walks in the browser and can be pushed, and open it. It needs
    no compiler, no display and no network."""

    out: Path = Path("jaxwalk-demo.html")
    """File for the page, replaced if there; .html."""
    open: bool = True
    """Whether it is opened in the browser, where there is one."""

    def check(self) -> None:
        """As `Options.check`."""
        if self.out.suffix.lower() != ".html":
            raise UserError(f"--out {self.out}: give a file that ends in .html")
        files.check_output("--out", self.out)


read = reader(DemoArgs, "demo")
