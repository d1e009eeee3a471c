"""What a measurement says on the screen while it goes on."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

Tell = Callable[[str, float], None]
"""Called with what is under way, and the share of it that is done."""


@contextmanager
def bars(console: Console) -> Iterator[Tell]:
    """A bar on a terminal for each thing that is told of, until it is done."""
    columns = TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn()
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as progress:
        shown: dict[str, Any] = {}

        def tell(what: str, share: float) -> None:
            if what not in shown:
                shown[what] = progress.add_task(what, total=1.0)
            progress.update(shown[what], completed=share, visible=share < 1)

        yield tell
