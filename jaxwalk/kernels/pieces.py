"""Cuts a graph's nodes into pieces, one after another, where few numbers have to be handed on.

Compilers' time grows faster than a kernel's length: ten kernels of a thousand operations compile in a
fraction of one of ten thousand.
"""

from __future__ import annotations

import itertools
from typing import NamedTuple

from jaxwalk.kernels.graph import Entry, Node, known, reach


class Piece(NamedTuple):
    """Nodes that are computed together.

    Attributes:
      nodes: in order.
      takes: inputs and nodes of earlier pieces that it reads.
      gives: its nodes that later pieces, or the results, read.
    """

    nodes: list[Node]
    takes: list[Node]
    gives: list[Node]


def cut(results: list[Entry], size: int) -> list[Piece]:
    """The nodes that ``results`` need, in pieces of 0.75 to 1.25 times ``size`` >= 2, but for the last."""
    nodes = reach(results)
    bounds = _bounds(nodes, results, size)
    of = {}
    for piece, (begin, end) in enumerate(itertools.pairwise(bounds)):
        of |= {node.index: piece for node in nodes[begin:end]}
    takes: list[dict[int, Node]] = [{} for _ in bounds[1:]]
    gives: list[dict[int, Node]] = [{} for _ in bounds[1:]]
    for node in nodes:
        for arg in node.args:
            if known(arg) or (arg.op != "input" and of[arg.index] == of[node.index]):
                continue
            takes[of[node.index]][arg.index] = arg
            if arg.op != "input":
                gives[of[arg.index]][arg.index] = arg
    for result in results:
        if not known(result) and result.op != "input":
            gives[of[result.index]][result.index] = result
    return [
        Piece(nodes[begin:end], [*took.values()], [*gave.values()])
        for (begin, end), took, gave in zip(itertools.pairwise(bounds), takes, gives, strict=True)
    ]


def _bounds(nodes: list[Node], results: list[Entry], size: int) -> list[int]:
    """Where the pieces begin, and the end."""
    alive = _alive(nodes, results)
    bounds = [0]
    while len(nodes) - bounds[-1] > 1.25 * size:
        first, last = bounds[-1] + int(0.75 * size), bounds[-1] + int(1.25 * size)
        bounds.append(min(range(first, last), key=lambda at: alive[at]))
    return [*bounds, len(nodes)]


def _alive(nodes: list[Node], results: list[Entry]) -> list[int]:
    """How many nodes before each place are read at or after it."""
    place = {node.index: at for at, node in enumerate(nodes)}
    last = {}
    for at, node in enumerate(nodes):
        last |= {arg.index: at for arg in node.args if not known(arg) and arg.op != "input"}
    last |= {x.index: len(nodes) for x in results if not known(x) and x.op != "input"}
    change = [0] * (len(nodes) + 2)
    for index, end in last.items():
        change[place[index] + 1] += 1
        change[end + 1] -= 1
    alive, count = [], 0
    for at in range(len(nodes) + 1):
        count += change[at]
        alive.append(count)
    return alive
