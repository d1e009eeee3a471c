"""An unrolled function as native code for this processor: a block of walkers a vector, called from XLA."""

from __future__ import annotations

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

SIZE = 4500
"""Operations in a function: a compiler's time grows faster than a function's length, and several are compiled
at once. One of 16,000 takes twice the time of four of 4,000, and is a fiftieth faster."""


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


def sources(plan: Plan) -> tuple[str, ...]:
    """The C++ of ``plan``, in several files that make one library: a function ``walk`` that XLA can call."""
    moving: dict[
        int, int
    ] = {}  # numbers that change, by index, and where in the block's moving part they lie
    news: list[Entry] = []
    for number, entries in plan.state:
        for old, new in zip(plan.given[number], entries, strict=True):
            if new is not old:
                moving[old.index] = len(moving)
                news.append(new)
    fixed: dict[int, int] = {}
    for node in (node for nodes in plan.given for node in nodes):
        if node.index not in moving:
            fixed.setdefault(node.index, len(fixed))
    told = [x for entries in plan.rows for x in entries]
    lie = {index: Slot("block", row) for index, row in fixed.items()}
    lie |= {index: Slot("now", row) for index, row in moving.items()}
    results = [(Slot("next", row), new) for row, new in enumerate(news)]
    results += [(Slot("row", row), x) for row, x in enumerate(told)]
    opening = (
        f"const F *const now = block + {len(fixed)} + turn * {len(moving)};\n"
        f"F *const next = block + {len(fixed)} + (1 - turn) * {len(moving)};"
    )
    pieces, tick = _pieces(results, lie, opening)

    def place(node: Node, turn: int) -> int:
        """Where a number lies in the block before a tick of that turn."""
        if node.index in moving:
            return len(fixed) + turn * len(moving) + moving[node.index]
        return fixed[node.index]

    changed = [plan.given[number] for number, _ in plan.state]
    at = iter(range(len(told)))
    tables = [
        _table("GIVEN", plan.given, [[place(x, 0) for x in nodes] for nodes in plan.given]),
        _table("KEPT", changed, [[place(x, 0) for x in nodes] for nodes in changed]),
        _table("MOVED", changed, [[place(x, 1) for x in nodes] for nodes in changed]),
        _table("TOLD", plan.rows, [[next(at) for _ in entries] for entries in plan.rows]),
    ]
    call = (
        f"return run<{len(fixed)}, {len(moving)}, {len(told)}>(frame, tick, GIVEN, {len(plan.given)}, "
        f"KEPT, MOVED, {len(changed)}, TOLD, {len(plan.rows)});"
    )
    head = [*map(_header, ("lanes.h", "maths.h"))]
    main = [
        *head,
        _header("call.h"),
        tick,
        *tables,
        _EXPORT + f"XLA_FFI_Error *walk(XLA_FFI_CallFrame *frame) {{\n{call}\n}}\n",
    ]
    return "\n".join(main), *("\n".join([*head, piece]) for piece in pieces)


def _pieces(results: list[tuple[Slot, Entry]], lie: dict[int, Slot], opening: str) -> tuple[list[str], str]:
    """The functions that a tick is cut into, and the tick that calls them.

    Args:
      results: where they are to be put. lie: where what is given lies, by index. opening: of each function.
    """
    pieces = cut([x for _, x in results], SIZE)
    handed = [x.index for piece in pieces[:-1] for x in piece.gives if x.index not in lie]
    kept = {index: Slot("kept", row) for row, index in enumerate(handed)}
    of = {node.index: number for number, piece in enumerate(pieces) for node in piece.nodes}
    last = len(pieces) - 1
    declarations, texts = [], []
    for number, piece in enumerate(pieces):
        nodes = [x for x in piece.nodes if x.index not in lie]
        before = {index: slot for index, slot in kept.items() if of[index] < number}
        puts = [(kept[x.index], x) for x in nodes if x.index in kept]
        puts += [(slot, x) for slot, x in results if (last if known(x) else of.get(x.index, last)) == number]
        declarations.append(
            f"void piece{number}(F *__restrict block, int turn, F *__restrict row, F *__restrict kept)"
        )
        texts.append(cpp.function(declarations[-1], nodes, lie | before, puts, opening))
    calls = [f"piece{number}(block, turn, row, kept);" for number in range(len(pieces))]
    tick = [
        *(f"{declaration};" for declaration in declarations),
        "static void tick(F *block, int turn, F *row) {",
        f"alignas(64) F kept[{len(kept) + 1}];",
        *calls,
        "}",
    ]
    return texts, "\n".join(tick)


_EXPORT = 'extern "C" __attribute__((visibility("default"))) '


def _header(name: str) -> str:
    lines = (resources.files("jaxwalk.kernels") / "native" / name).read_text().splitlines()
    return "\n".join(line for line in lines if not line.startswith(('#include "lanes', "#pragma once")))


def _table(name: str, arrays: Sequence[Sequence[Entry]], places: Sequence[Sequence[int]]) -> str:
    """``arrays`` as `call.h` wants to be told of them."""
    lines = [f"static const int {name}_{i}[] = {{{', '.join(map(str, x))}}};" for i, x in enumerate(places)]
    told = [
        f"{{{'FLAG' if cpp.letter(x[0].dtype) == 'B' else 'NUMBER'}, {len(x)}, {name}_{i}}}"
        for i, x in enumerate(arrays)
    ]
    lines.append(f"static const Array {name}[] = {{{', '.join(told) or '{NUMBER, 0, nullptr}'}}};")
    return "\n".join(lines)


@functools.cache
def width() -> int:
    """Walkers that native code moves at once here, a number of each in one of the processor's vectors.

    Raises:
      compiler.BuildError: there can be no native code.
    """
    headers = map(_header, ("lanes.h", "maths.h", "call.h"))
    return compiler.compiled(("\n".join([*headers, f"{_EXPORT}int width() {{ return W; }}\n"]),), "width")()


def target(texts: tuple[str, ...]) -> str:
    """The name under which XLA can call what `sources` compile to.

    Raises:
      compiler.BuildError: it does not, here; it is not tried again.
    """
    found = _target(texts, compiler.FLAGS)
    if isinstance(found, compiler.BuildError):
        raise found
    return found


@functools.cache
def _target(texts: tuple[str, ...], flags: tuple[str, ...]) -> str | compiler.BuildError:
    name = f"walk_{hashlib.sha256(''.join((*texts, *flags)).encode()).hexdigest()[:24]}"
    try:
        found = compiler.compiled(texts, "walk")
    except compiler.BuildError as error:
        return error
    jax.ffi.register_ffi_target(name, jax.ffi.pycapsule(found), platform="cpu")
    return name


def call(
    name: str,
    given: Sequence[jax.Array],
    results: Sequence[jax.ShapeDtypeStruct],
    reused: dict[int, int],
    ticks: int,
    flops: int,
) -> list[jax.Array]:
    """``ticks`` ticks of one walker; under `jax.vmap`, of all.

    Args:
      given: as the plan has them. results: shapes and types, state first, then rows.
      reused: for each array of the state, the argument whose memory it takes.
      flops: of one walker's tick, for whoever reads the program's cost.
    """
    return list(
        jax.ffi.ffi_call(name, list(results), vmap_method="broadcast_all", input_output_aliases=reused)(
            *given, ticks=np.int64(ticks), flops=np.int64(ticks * flops), size=np.int64(given[0].size)
        )
    )
