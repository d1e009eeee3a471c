"""What a compiled program costs by XLA's own analysis, with its loops counted as often as they turn.

XLA counts the body of a loop once. Here the body of each loop is made the entry of the program and analysed
alone, so that every figure is XLA's own; only the turns are multiplied in.
"""

from __future__ import annotations

import importlib
import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import jax

_HEAD = re.compile(r"^(ENTRY )?%?([\w.\-]+) \(.*\) -> .* \{$")
_LOOP = re.compile(r" while\(.*condition=%?([\w.\-]+), body=%?([\w.\-]+)")
_TURNS = re.compile(r'"known_trip_count":\{"n":"(\d+)"\}')
_CALLED = re.compile(r"(?:calls|to_apply|true_computation|false_computation|select|scatter)=%?([\w.\-]+)")
_BRANCHES = re.compile(r"(?:branch|called)_computations=\{([^}]*)\}")
_KERNEL = re.compile(
    r'serialized_metadata = "\{\\22flops\\22: \\22(\d+)\\22, \\22bytes\\22: \\22(\d+)\\22\}"'
)
_NATIVE = re.compile(
    r'custom_call_target="walk_\w+", operand_layout_constraints=\{\w+\[([\d,]*)\].*'
    r"backend_config=\{flops = (\d+) : i64, size = (\d+) : i64"
)
_METADATA = re.compile(r', metadata=\{(?:[^{}"]|"[^"]*")*\}')


@dataclass(frozen=True)
class Cost:
    """What one call costs on one device.

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


def of(compiled: Any, solver: float, others: float = 0.0) -> Cost | None:
    """What one call of ``compiled`` costs.

    Args:
      compiled: of ``jax.jit(...).lower(...).compile()``.
      solver: how often a loop of MJX's solver turns, which its data end.
      others: the same of any other such loop (the updates).

    Returns:
      None where this JAX has no such analysis, or the program no text that it reads.
    """
    try:
        parse = importlib.import_module("jaxlib._hlo").hlo_module_from_text
        cost_analysis = importlib.import_module("jaxlib._jax").hlo_module_cost_analysis
    except (ImportError, AttributeError):  # neither is public
        return None
    client = jax.devices()[0].client

    def analyse(text: str) -> Cost:
        told = cost_analysis(client, parse(text))
        return Cost(told.get("flops", 0.0), told.get("bytes accessed", 0.0))

    text = compiled.as_text()
    if text is None:
        return None
    try:
        return _Program(text, analyse, solver, others).total()
    except jax.errors.JaxRuntimeError:  # it cannot read its own text: better no figure than no measurement
        return None


class _Program:
    """The computations of a program's text, and what each costs."""

    def __init__(self, text: str, analyse: Callable[[str], Cost], solver: float, others: float) -> None:
        self.analyse, self.solver, self.others = analyse, solver, others
        self.bodies: dict[str, list[str]] = {}
        self.entry = name = ""
        parted = re.search(r", num_partitions=\d+", text.split("\n", 1)[0])
        self.head = f"HloModule program{parted[0] if parted else ''}"
        for line in text.splitlines():
            if head := _HEAD.match(line):
                name = head[2]
                self.bodies[name] = [line.removeprefix("ENTRY ")]
                self.entry = name if head[1] else self.entry
            elif name:
                self.bodies[name].append(line)
        self._known: dict[str, Cost] = {}

    def total(self) -> Cost:
        return self.once(self.entry) + self.more(self.entry)

    def once(self, name: str) -> Cost:
        """What ``name`` costs by XLA's analysis, every loop within turning once."""
        if name not in self._known:
            text = self.alone(name)
            self._known[name] = self.analyse(text) + _kernels(text)
        return self._known[name]

    def alone(self, name: str) -> str:
        """The text of a program that is the computation ``name`` and what it calls."""
        needed, open_ = {name}, [name]
        while open_:
            found = {part for line in self.bodies[open_.pop()] for part in _called(line)} - needed
            needed |= found
            open_ += found
        lines = [self.head]
        for one, body in self.bodies.items():  # in their order: what is called comes first
            if one in needed:
                lines += [f"ENTRY {body[0]}" if one == name else body[0], *body[1:]]
        return _METADATA.sub("", "\n".join(lines))

    def more(self, name: str) -> Cost:
        """What the loops in ``name``, and in all that it calls, cost beyond their first turn."""
        found = Cost()
        for line in self.bodies[name]:
            if loop := _LOOP.search(line):
                turns = self.turns(line)
                for part in loop.groups():
                    found += self.once(part) * (turns - 1) + self.more(part) * turns
            elif " conditional(" in line:  # XLA, too, counts the dearest branch
                found += max(map(self.more, _called(line)), key=lambda cost: cost.flops)
            else:
                for part in _called(line):
                    found += self.more(part)
        return found

    def turns(self, line: str) -> float:
        """How often the loop in ``line`` turns."""
        if known := _TURNS.search(line):
            return float(known[1])
        return self.solver if "solve/while" in line else self.others


def _kernels(text: str) -> Cost:
    """What the kernels in ``text`` cost, which tell it themselves: XLA knows nothing of them.

    Of native code XLA counts the bytes: what goes in and what comes out.
    """
    flops, moved = 0, 0
    for one in _NATIVE.finditer(text):
        walkers = math.prod(map(int, filter(None, one[1].split(",")))) // int(one[3])
        flops += walkers * int(one[2])
    for one in _KERNEL.finditer(text):
        flops, moved = flops + int(one[1]), moved + int(one[2])
    return Cost(float(flops), float(moved))


def _called(line: str) -> list[str]:
    """The computations that an instruction names."""
    loop, branches = _LOOP.search(line), _BRANCHES.search(line)
    named = [*loop.groups()] if loop else []
    if branches:
        named += [part.strip(" %") for part in branches[1].split(",")]
    return named + _CALLED.findall(line)
