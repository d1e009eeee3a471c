"""An unrolled function as native code for this processor: a block of walkers a vector, called from XLA."""

from __future__ import annotations

import ctypes
import functools
import hashlib
from collections.abc import Sequence
from importlib import resources
from typing import NamedTuple

import jax
import numpy as np

from jaxwalk.kernels import compiler, cpp
from jaxwalk.kernels.cpp import Slot
from jaxwalk.kernels.graph import Entry, Node, known
from jaxwalk.kernels.pieces import cut

SIZE = 100_000
"""Operations in a function."""


class Plan(NamedTuple):
    """What is computed, in single numbers.

    Attributes:
      given: of each array that goes in, its numbers.
      state: of each array that comes out at the end, which of ``given`` it follows, and its new numbers.
      rows: of each array that is written at every tick, its numbers.
    """

    given: list[list[Node]]
    state: list[tuple[int, list[Entry]]]
    rows: list[list[Entry]]


def source(plan: Plan, size: int = SIZE) -> str:
    """The C++ of ``plan``: a function ``walk`` that XLA can call."""
    moving: dict[int, int] = {}  # entries that change, by index, and where in the block's moving part
    news: list[Entry] = []
    for number, entries in plan.state:
        for old, new in zip(plan.given[number], entries, strict=True):
            if new is not old and old.index not in moving:
                moving[old.index] = len(moving)
                news.append(new)
    fixed: dict[int, int] = {}
    for nodes in plan.given:
        for node in nodes:
            if node.index not in moving:
                fixed.setdefault(node.index, len(fixed))
    sources = {index: Slot("block", row) for index, row in fixed.items()}
    sources |= {index: Slot("now", row) for index, row in moving.items()}
    results = [(Slot("next", row), new) for row, new in enumerate(news)]
    told = [x for entries in plan.rows for x in entries]
    results += [(Slot("row", row), x) for row, x in enumerate(told)]

    def place(node: Node, turn: int) -> int:
        if node.index in moving:
            return len(fixed) + turn * len(moving) + moving[node.index]
        return fixed[node.index]

    functions = _functions(results, sources, size, len(fixed), len(moving))
    begin = [[place(x, 0) for x in nodes] for nodes in plan.given]
    ends = [[[place(x, turn) for x in plan.given[number]] for number, _ in plan.state] for turn in (0, 1)]
    at = iter(range(len(told)))
    written = [[next(at) for _ in entries] for entries in plan.rows]
    kinds = [nodes[0].dtype.kind for nodes in plan.given]
    state_kinds = [kinds[number] for number, _ in plan.state]
    row_kinds = [entries[0].dtype.kind for entries in plan.rows]
    return "\n".join(
        [
            _LANES,
            *(_header(name) for name in ("lanes.h", "maths.h", "call.h")),
            functions,
            _arrays("GIVEN", kinds, begin),
            _arrays("KEPT", state_kinds, ends[0]),
            _arrays("MOVED", state_kinds, ends[1]),
            _arrays("TOLD", row_kinds, written),
            'extern "C" XLA_FFI_Error *walk(XLA_FFI_CallFrame *frame) {',
            f"return run<{len(fixed)}, {len(moving)}, {len(told)}>(frame, tick, GIVEN, {len(kinds)}, "
            f"KEPT, MOVED, {len(state_kinds)}, TOLD, {len(row_kinds)});",
            "}",
            "",
        ]
    )


def _functions(
    results: list[tuple[Slot, Entry]], sources: dict[int, Slot], size: int, fixed: int, moving: int
) -> str:
    """The pieces of a tick, and the tick that calls them."""
    opening = (
        f"const F *const now = block + {fixed} + turn * {moving};\n"
        f"F *const next = block + {fixed} + (1 - turn) * {moving};"
    )
    pieces = cut([x for _, x in results], size)
    kept: dict[int, Slot] = {}
    for piece in pieces[:-1]:
        for node in piece.gives:
            if node.index not in sources:
                kept[node.index] = Slot("kept", len(kept))
    parameters = "F *__restrict block, int turn, F *__restrict row, F *__restrict kept"
    texts, own = [], {node.index: number for number, piece in enumerate(pieces) for node in piece.nodes}
    for number, piece in enumerate(pieces):
        nodes = [x for x in piece.nodes if x.index not in sources]
        here = {index: slot for index, slot in kept.items() if own[index] != number}
        puts = [(kept[x.index], x) for x in nodes if x.index in kept]
        last = len(pieces) - 1
        puts += [
            (slot, x)
            for slot, x in results
            if (last if known(x) or x.index in sources else own[x.index]) == number
        ]
        texts.append(cpp.function(f"piece{number}", parameters, nodes, sources | here, puts, opening))
    calls = "\n".join(f"piece{number}(block, turn, row, kept);" for number in range(len(pieces)))
    texts.append(
        f"static void tick(F *block, int turn, F *row) {{\nalignas(64) F kept[{len(kept) + 1}];\n{calls}\n}}"
    )
    return "\n".join(texts)


_LANES = """#ifndef W
#if defined(__AVX512F__)
#define W 16
#elif defined(__AVX2__)
#define W 8
#elif defined(__aarch64__) || defined(__SSE2__)
#define W 4
#else
#define W 1
#endif
#endif"""


def _header(name: str) -> str:
    text = (resources.files("jaxwalk.kernels") / "native" / name).read_text()
    return "\n".join(
        line for line in text.splitlines() if not line.startswith(('#include "lanes', "#pragma once"))
    )


def _arrays(name: str, kinds: Sequence[str], places: Sequence[Sequence[int]]) -> str:
    """A table of `Array`s."""
    lines = [f"static const int {name}_{i}[] = {{{', '.join(map(str, x))}}};" for i, x in enumerate(places)]
    told = [
        f"{{{'FLAG' if kind == 'b' else 'NUMBER'}, {len(x)}, {name}_{i}}}"
        for i, (kind, x) in enumerate(zip(kinds, places, strict=True))
    ]
    return "\n".join(
        [*lines, f"static const Array {name}[] = {{{', '.join(told) or '{NUMBER, 0, nullptr}'}}};"]
    )


@functools.cache
def width() -> int:
    """Walkers that native code moves at once here, a number of each in one of the processor's vectors.

    Raises:
      compiler.BuildError: there can be no native code.
    """
    return compiler.library(_LANES + '\nextern "C" int width() { return W; }\n').width()


@functools.cache
def target(text: str) -> str:
    """The name under which XLA can call what ``text`` compiles to.

    Raises:
      compiler.BuildError: it does not, here.
    """
    name = f"jaxwalk_{hashlib.sha256(text.encode()).hexdigest()[:24]}"
    found = compiler.library(text)
    _loaded.append(found)
    jax.ffi.register_ffi_target(name, jax.ffi.pycapsule(found.walk), platform="cpu")
    return name


_loaded: list[ctypes.CDLL] = []  # never given up: XLA keeps the addresses


def call(
    name: str,
    given: Sequence[jax.Array],
    results: Sequence[jax.ShapeDtypeStruct],
    reused: dict[int, int],
    ticks: int,
) -> list[jax.Array]:
    """``ticks`` ticks of one walker; under `jax.vmap`, of all.

    Args:
      given: as the plan has them. results: shapes and types, state first, then rows.
      reused: for each array of the state that has its form, the argument whose memory it takes.
    """
    return list(
        jax.ffi.ffi_call(name, list(results), vmap_method="broadcast_all", input_output_aliases=reused)(
            *given, ticks=np.int64(ticks)
        )
    )
