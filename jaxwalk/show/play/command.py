"""``jaxwalk play``: a page whose walker is simulated in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console

from jaxwalk.common import files
from jaxwalk.learn.policies import named
from jaxwalk.learn.policies.named import Subject
from jaxwalk.options import lines
from jaxwalk.show.play import page
from jaxwalk.show.web import browser

if TYPE_CHECKING:
    from jaxwalk.show.play.options import PlayArgs


def main(args: PlayArgs) -> None:
    """Run ``jaxwalk play``.

    Raises:
      UserError: no such policy, one that no page can walk by, or the file cannot be written.
    """
    who = {name: getattr(args, name) for name in ("speed", "height", "mass", "noise")}
    write(args.out, named.load(args.policy, **who), lines.line("play", args), args.open)


def write(out: Path, subject: Subject, command: str, opens: bool) -> None:
    """Write ``subject``'s page, and open it in the browser, if that is wanted and there is one.

    Raises:
      UserError: as for `main`.
    """
    files.write_bytes(out, page.html(subject, named.origin(subject.name), command))
    console = Console(markup=False)
    console.print(f"{out.resolve()}: {subject.name} walks there, and can be pushed", highlight=False)
    if not browser.opened(out, opens):
        console.print("open that file in a browser", highlight=False)
