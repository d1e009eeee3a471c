"""What a compiled program costs by XLA's own analysis, with its loops counted as often as they turn.

XLA counts the body of a loop once. Here the body of each loop is made the entry of the program and analysed
alone, so that every figure is XLA's own; only the turns are multiplied in.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import jax

_HEAD = re.compile(r"^(ENTRY )?%?([\w.\-]+) \(.*\) -> .* \{$")
_LOOP = re.compile(r" while\(.*condition=%?([\w.\-]+), body=%?([\w.\-]+)")
_TURNS = re.compile(r'"known_trip_count":\{"n":"(\d+)"\}')
_CALLED = re.compile(r"(?:calls|to_apply|true_computation|false_computation)=%?([\w.\-]+)")
_BRANCHES = re.compile(r"branch_computations=\{([^}]*)\}")


@dataclass(frozen=True)
class Cost:
    """Of one call, on one device.

    Attributes:
      flops: floating-point operations; those of calls to libraries (LAPACK) are not known to XLA.
      bytes: read and written by the program's operations, wherever they lie: caches count as memory.
    """

    flops: float = 0.0
    bytes: float = 0.0

    def __add__(self, other: Cost) -> Cost:
        return Cost(self.flops + other.flops, self.bytes + other.bytes)

    def __mul__(self, times: float) -> Cost:
        return Cost(self.flops * times, self.bytes * times)


def of(compiled: Any, open_loops: Sequence[float], last_loop: float = 0.0) -> Cost | None:
    """What one call of ``compiled`` costs.

    Args:
      compiled: of ``jax.jit(...).lower(...).compile()``.
      open_loops: how often a loop turns that ends by its data, the outer ones first: of those that hold
        each other, as the physics' solver (Newton iterations, and a line search in each).
      last_loop: the same for such a loop that neither holds another nor lies in one (the updates).

    Returns:
      None where this JAX has no such analysis, or the program no text.
    """
    try:
        from jaxlib import _hlo
        from jaxlib._jax import hlo_module_cost_analysis
    except ImportError:
        return None
    client = jax.devices()[0].client

    def analyse(text: str) -> Cost:
        told = hlo_module_cost_analysis(client, _hlo.hlo_module_from_text(text))
        return Cost(told.get("flops", 0.0), told.get("bytes accessed", 0.0))

    text = compiled.as_text()
    return None if text is None else _Program(text, analyse, tuple(open_loops), last_loop).total()


class _Program:
    """The computations of a program's text, and what each costs."""

    def __init__(self, text: str, analyse: Any, open_loops: tuple[float, ...], last_loop: float) -> None:
        self.analyse, self.open_loops, self.last_loop = analyse, open_loops, last_loop
        self.bodies: dict[str, list[str]] = {}
        self.entry = name = ""
        for line in text.splitlines():
            if head := _HEAD.match(line):
                name = head[2]
                self.bodies[name] = []
                self.entry = name if head[1] else self.entry
            elif name:
                self.bodies[name].append(line)
        self.plain = self._enterable(text)
        self._known: dict[str, Cost] = {}

    @staticmethod
    def _enterable(text: str) -> str:
        """The program with no computation as its entry, nor what is said of that one."""
        text = re.sub(
            r", (entry_computation_layout|allow_spmd\w+|alias_passthrough\w*)=\{.*$", "", text, flags=re.M
        )
        return re.sub(r"^ENTRY ", "", text, flags=re.M)

    def once(self, name: str) -> Cost:
        """By XLA's analysis, every loop within turning once."""
        if name not in self._known:
            head = re.compile(rf"^(?=%?{re.escape(name)} \()", re.M)
            self._known[name] = self.analyse(head.sub("ENTRY ", self.plain, count=1))
        return self._known[name]

    def total(self) -> Cost:
        return self.once(self.entry) + self.more(self.entry, 0)

    def more(self, name: str, depth: int) -> Cost:
        """What the loops in ``name``, and in all that it calls, cost beyond their first turn.

        Args:
          depth: how many open loops it lies in.
        """
        found = Cost()
        for line in self.bodies.get(name, ()):
            if loop := _LOOP.search(line):
                known = _TURNS.search(line)
                turns = float(known[1]) if known else self._turns(loop[2], depth)
                within = depth if known else depth + 1
                turn = Cost()
                for part in loop.groups():
                    turn += self.once(part)
                    found += self.more(part, within) * turns
                found += turn * (turns - 1)
            elif branches := _BRANCHES.search(line):
                parts = [self.more(part.strip(" %"), depth) for part in branches[1].split(",")]
                found += max(parts, key=lambda cost: cost.flops)  # XLA, too, counts the dearest branch
            else:
                for part in _CALLED.findall(line):
                    found += self.more(part, depth)
        return found

    def _turns(self, body: str, depth: int) -> float:
        alone = depth == 0 and not self._holds_open(body)
        if alone or not self.open_loops:
            return self.last_loop
        return self.open_loops[min(depth, len(self.open_loops) - 1)]

    def _holds_open(self, name: str) -> bool:
        for line in self.bodies.get(name, ()):
            loop = _LOOP.search(line)
            if loop and not _TURNS.search(line):
                return True
            parts = [*(loop.groups() if loop else ()), *_CALLED.findall(line)]
            if branches := _BRANCHES.search(line):
                parts += [part.strip(" %") for part in branches[1].split(",")]
            if any(self._holds_open(part) for part in parts):
                return True
        return False
