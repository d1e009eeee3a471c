"""The programs take turns, round by round, so that a machine that slows down or is shared slows all of them.

All advance the same bodies by the same number of ticks a call, split over all devices.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import jax

BARE, TICK, MAP, LOOP = "mjx_step", "tick", "push_map", "training_loop"
BY_XLA = "tick_by_xla"  # the tick without native code or kernels
SAVING = "training_loop_saving"  # the loop, while a checkpoint of it is written
MIN_ROUNDS = 3
Run = Callable[[], tuple[float, float]]
"""One call, from nothing, finished when it returns; gives footsteps and updates made."""
_CACHE_HIT = "/jax/compilation_cache/cache_hits"


@dataclass
class Program:
    """A compiled program and what was measured of it.

    Attributes:
      run: one call.
      compile_seconds: tracing included. cached: the compiled program came from JAX's cache.
      seconds, footsteps, updates: of each round.
      processor: of each round, s of all of this process's threads: what others take does not count.
    """

    run: Run
    compile_seconds: float
    cached: bool
    seconds: list[float] = field(default_factory=list)
    footsteps: list[float] = field(default_factory=list)
    updates: list[float] = field(default_factory=list)
    processor: list[float] = field(default_factory=list)

    def time(self) -> None:
        """Make one call, and note how long it took and what it made."""
        begun, spent = time.perf_counter(), time.process_time()
        footsteps, updates = self.run()
        self.seconds.append(time.perf_counter() - begun)
        self.processor.append(time.process_time() - spent)
        self.footsteps.append(footsteps)
        self.updates.append(updates)

    def rate(self, amounts: list[float]) -> float:
        """Median over the rounds of ``amounts`` a second."""
        return statistics.median(a / s for a, s in zip(amounts, self.seconds, strict=True))


class Builder:
    """Compiles programs, and tells how long that took and which of them JAX found in its cache.

    Args:
      report: called with what is under way.
    """

    def __init__(self, report: Callable[[str], None]) -> None:
        self.hits = 0
        self._report = report
        jax.monitoring.register_event_listener(self._hear)

    def _hear(self, event: str, **_: Any) -> None:
        self.hits += event == _CACHE_HIT

    def build(self, name: str, function: Any, *args: Any) -> tuple[Any, tuple[float, bool]]:
        """``function``, jitted, compiled for ``args``; and what `Program` keeps of that."""
        return self.clocked(name, lambda: function.lower(*args).compile())

    def clocked(self, name: str, compiled: Callable[[], Any]) -> tuple[Any, tuple[float, bool]]:
        """As `build`, where ``compiled`` compiles."""
        self._report(f"compiling {name}")
        begun, before = time.perf_counter(), self.hits
        program = compiled()
        return program, (time.perf_counter() - begun, self.hits > before)


def take_turns(
    programs: dict[str, Program],
    seconds: float,
    report: Callable[[str], None],
    beside: Sequence[Program] = (),
) -> None:
    """Round by round, until each was timed for ``seconds`` or `MIN_ROUNDS` calls, whichever is more.

    Args:
      beside: have their turns in every round, too, and do not tell when it is enough.
    """
    while any(len(p.seconds) < MIN_ROUNDS or sum(p.seconds) < seconds for p in programs.values()):
        report(f"round {1 + min(len(p.seconds) for p in programs.values())}")
        for program in (*programs.values(), *beside):
            program.time()
