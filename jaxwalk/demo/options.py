"""``jaxwalk demo``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from jaxwalk.common import files
from jaxwalk.common.errors import UserError
from jaxwalk.options.parse import reader


@dataclass(frozen=True)
class DemoArgs:
    """Push the shipped policy, and put that on a page: by its exported controller, in NumPy, on C MuJoCo. It
    needs no compiler and no display."""

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
