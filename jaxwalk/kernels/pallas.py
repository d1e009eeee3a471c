"""An unrolled function as Pallas kernels: one for each piece, a walker to a thread."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import jax
import jax.numpy as jnp
from jax.experimental import pallas as pl
from jax.experimental.pallas import triton
from jaxtyping import Array, Shaped

from jaxwalk.kernels.emit import emit, value
from jaxwalk.kernels.graph import ARITHMETIC, Entry, Node, known
from jaxwalk.kernels.pieces import cut

SIZE = 1200
"""Operations in a kernel. On an H200 a tick of 65,536 walkers takes 219 us by kernels of 1,200 operations,
306 of 600, 366 of 300. Triton compiles a kernel in a time that grows with its length times its accesses to
memory, since it follows each of these through the whole of it."""
BLOCK = 64
"""Walkers that a kernel's program moves together, two warps; 32 and 128 are as fast."""

_Stacks = list[Shaped[Array, "_ B"]]
_Place = tuple[int, int]  # which array, and which of its rows


def kernels(
    arguments: Sequence[Sequence[Node]],
    results: Sequence[Sequence[Entry]],
    reused: Mapping[int, int] | None = None,
    interpret: bool = False,
) -> Callable[[_Stacks], _Stacks]:
    """What computes ``results`` from ``arguments``, lists of numbers, for B walkers.

    Args:
      arguments, results: of each array, its entries.
      reused: for a result, the argument in whose memory it is written, of its own length and type.
      interpret: runs on any device, for tests.

    Returns:
      A function of [n, B] arrays, one for each of ``arguments``, to [n, B] arrays.
    """
    wanted = [x for result in results for x in result]
    *first, last = cut(wanted, SIZE)
    # The last hands on what earlier ones have computed, so that a result is one array.
    own = {node.index for node in last.nodes}
    passed = [x for x in wanted if not known(x) and x.index not in own]

    def run(stacks: _Stacks) -> _Stacks:
        count = stacks[0].shape[1]
        width = -(-count // BLOCK) * BLOCK
        stacks = [jnp.pad(x, ((0, 0), (0, width - count)), mode="edge") for x in stacks]
        place = {node.index: (i, row) for i, nodes in enumerate(arguments) for row, node in enumerate(nodes)}
        for piece in first:
            given = _by_type(piece.gives)
            place |= {
                x.index: (len(stacks) + i, row) for i, xs in enumerate(given) for row, x in enumerate(xs)
            }
            stacks += _call(piece.nodes, piece.takes, place, stacks, given, {}, interpret)
        done = _call(last.nodes, [*last.takes, *passed], place, stacks, results, reused or {}, interpret)
        return [x[:, :count] for x in done]

    return run


def _call(
    nodes: list[Node],
    takes: list[Node],
    place: dict[int, _Place],
    stacks: _Stacks,
    gives: Sequence[Sequence[Entry]],
    reused: Mapping[int, int],
    interpret: bool,
) -> _Stacks:
    """One kernel: ``nodes``, from ``takes``, which lie at ``place``; writes ``gives``, array by array."""
    width = stacks[0].shape[1]
    read = sorted({place[node.index][0] for node in takes} | {*reused.values()})
    number = {stack: i for i, stack in enumerate(read)}

    def kernel(*refs: Any) -> None:
        sources, targets = refs[: len(read)], refs[len(read) :]
        values = {}
        for node in takes:
            stack, row = place[node.index]
            values[node.index] = sources[number[stack]][row, :]
        emit(nodes, values, (BLOCK,))
        for target, entries in zip(targets, gives, strict=True):
            for row, entry in enumerate(entries):
                target[row, :] = value(entry, values, (BLOCK,))

    def block(rows: int) -> pl.BlockSpec:
        return pl.BlockSpec((rows, BLOCK), lambda i: (0, i))

    return list(
        pl.pallas_call(
            kernel,
            out_shape=[jax.ShapeDtypeStruct((len(x), width), x[0].dtype) for x in gives],
            grid=(width // BLOCK,),
            in_specs=[block(stacks[i].shape[0]) for i in read],
            out_specs=[block(len(x)) for x in gives],
            compiler_params=triton.CompilerParams(num_warps=BLOCK // 32, num_stages=1),
            input_output_aliases={number[stack]: i for i, stack in reused.items()},
            metadata={
                "flops": str(sum(node.op in ARITHMETIC for node in nodes) * width),
                "bytes": str(sum(x.dtype.itemsize for part in (takes, *gives) for x in part) * width),
            },
            interpret=interpret,
        )(*(stacks[i] for i in read))
    )


def _by_type(nodes: list[Node]) -> list[list[Node]]:
    """The nodes of each type together: those that one array can hold."""
    types = {}
    for node in nodes:
        types.setdefault(node.dtype, []).append(node)
    return [*types.values()]
