"""What a person sees while training runs: a live bar on a terminal, plain lines elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping
from types import TracebackType

from rich.console import Console, Group
from rich.live import Live
from rich.progress import BarColumn, TaskProgressColumn, TextColumn
from rich.progress import Progress as Bar
from rich.text import Text

_PLAIN_EVERY = 10.0  # s between plain lines
_SHOWN = (  # metric, label, format
    ("train/footsteps_per_second", "footsteps/s", "{:,.0f}"),
    ("train/reward", "reward", "{:.2f}"),
    ("train/falls_per_100", "falls/100", "{:.2f}"),
)


class Progress:
    """Progress over a known number of footsteps, on standard output. A context manager.

    Time left is reckoned from the first update on, so that compiling does not count.

    Args:
      shown: whether anything is; not by a process that others tell the same.
    """

    def __init__(self, total_footsteps: int, shown: bool = True) -> None:
        self._total, self._shown = total_footsteps, shown
        self._first: tuple[float, int] | None = None
        self._printed = float("-inf")
        self._console = Console(file=sys.stdout)
        self._live: Live | None = None
        if shown and self._console.is_terminal:
            self._bar = Bar(
                BarColumn(), TaskProgressColumn(), TextColumn("{task.description}"), console=self._console
            )
            self._task = self._bar.add_task("compiling", total=total_footsteps)
            self._metrics = Text()
            self._live = Live(Group(self._bar, self._metrics), console=self._console)

    def __enter__(self) -> Progress:
        if self._live:
            self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._live:
            self._live.stop()

    def update(self, footsteps: int, metrics: Mapping[str, float | int]) -> None:
        """Show the latest metrics.

        Args:
          footsteps: gathered so far, all walkers together.
          metrics: a row as it goes to ``metrics.jsonl``; what is missing is not shown.
        """
        if not self._shown:
            return
        now = time.monotonic()
        done, figures = self._done(now, footsteps), _figures(metrics)
        if self._live:
            self._bar.update(self._task, completed=footsteps, description=done)
            self._metrics.plain = figures
        elif now - self._printed >= _PLAIN_EVERY or footsteps >= self._total:
            self._printed = now
            print(f"{done}  {figures}", flush=True)

    def note(self, text: str) -> None:
        """A line that stays: an evaluation's result, a new best policy."""
        if self._live:
            self._console.print(text, markup=False, highlight=False)
        elif self._shown:
            print(text, flush=True)

    def _done(self, now: float, footsteps: int) -> str:
        if self._first is None:
            self._first = (now, footsteps)
        text = f"{footsteps:,} of {self._total:,} footsteps"
        started, before = self._first
        if footsteps > before and now > started:
            left = max(0, self._total - footsteps) * (now - started) / (footsteps - before)
            text += f", {_clock(left)} left"
        return text


def _figures(metrics: Mapping[str, float | int]) -> str:
    return "  ".join(
        f"{label} {form.format(metrics[name])}" for name, label, form in _SHOWN if name in metrics
    )


def _clock(seconds: float) -> str:
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{seconds:02}" if hours else f"{minutes}:{seconds:02}"
