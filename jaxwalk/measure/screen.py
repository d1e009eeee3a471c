"""What a measurement says on the screen while it goes on."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

OnProgress = Callable[[str, float], None]
"""Called with what is under way, and the share of it that is done."""
Tell = OnProgress  # as `measure.gait` calls it


@contextmanager
def bars(console: Console) -> Iterator[OnProgress]:
    """A bar on a terminal for each thing that is told of, until it is done."""
    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TaskProgressColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as shown_bars:
        shown: dict[str, Any] = {}

        def progress(what: str, share: float) -> None:
            if what not in shown:
                shown[what] = shown_bars.add_task(what, total=1.0)
            shown_bars.update(shown[what], completed=share, visible=share < 1)

        yield progress
