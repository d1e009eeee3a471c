"""Unrolled functions of one walker as C++ that wants no library: a compiler makes a WebAssembly module of it.

Each function becomes ``NAME(a, b, ..)``, of the places in memory where its arguments lie. An argument is all
numbers of a tree's leaves one after another, four bytes each, a random key as its two words, a truth value as
0 or 1. What a function changes of its first argument, or makes anew, is written there when all is computed.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import resources
from typing import Any, NamedTuple

import jax
import numpy as np

from jaxwalk.kernels import cpp
from jaxwalk.kernels.cpp import Slot
from jaxwalk.kernels.entries import Entries, inputs, words
from jaxwalk.kernels.graph import Entry, Graph, Unsupported, is_key, reach
from jaxwalk.kernels.unroll import unrolled

HEADERS = ("freestanding.h", "lanes.h", "maths.h")


class Function(NamedTuple):
    """A function to be emitted.

    Attributes:
      name: as C has it.
      function: of trees of arrays; its result has the form of its first argument.
      given: shapes and types of its arguments.
      fresh: its first argument is only written to, and not handed to ``function``.
    """

    name: str
    function: Callable[..., Any]
    given: tuple[Any, ...]
    fresh: bool = False


class Place(NamedTuple):
    """Where an array lies within its argument.

    Attributes:
      at: its first number. shape: of the array; of keys, with their words. kind: F, I, U or B.
    """

    at: int
    shape: tuple[int, ...]
    kind: str


def named(tree: Any) -> dict[str, Any]:
    """The leaves of ``tree`` by their paths (``walker.plant.qpos``), in order."""
    found = jax.tree_util.tree_leaves_with_path(tree)
    return {jax.tree_util.keystr(path, simple=True, separator="."): leaf for path, leaf in found}


def layout(tree: Any) -> dict[str, Place]:
    """Where each leaf of ``tree``, of shapes and types, lies, by its name."""
    places, at = {}, 0
    for name, leaf in named(tree).items():
        shape = (*leaf.shape, 2) if is_key(leaf.dtype) else tuple(leaf.shape)
        kind = "U" if is_key(leaf.dtype) else cpp.letter(leaf.dtype)
        places[name] = Place(at, shape, kind)
        at += int(np.prod(shape, dtype=int))
    return places


def source(functions: tuple[Function, ...]) -> str:
    """The C++ of ``functions``, whole.

    Raises:
      Unsupported: one of them does what cannot be unrolled.
    """
    return "\n".join([*map(_header, HEADERS), *map(_emitted, functions)])


def _header(name: str) -> str:
    lines = (resources.files("jaxwalk.kernels") / "native" / name).read_text().splitlines()
    left_out = ("#pragma once", "#include <c", '#include "')
    return "\n".join(line for line in lines if not line.startswith(left_out))


def _emitted(told: Function) -> str:
    graph = Graph()
    given = [jax.tree.leaves(inputs(graph, one)) for one in told.given]
    trees = [
        jax.tree.unflatten(jax.tree.structure(one), arrays)
        for one, arrays in zip(told.given, given, strict=True)
    ]
    result = unrolled(graph, told.function, *trees[told.fresh :])
    if _forms(jax.tree.leaves(result)) != _forms(given[0]):
        raise Unsupported(f"{told.name}: a result that has not the form of its first argument")
    names = [chr(ord("a") + i) for i in range(len(given))]
    lie = {
        node.index: Slot(name, row)
        for name, arrays in zip(names, given, strict=True)
        for row, node in enumerate(_flat(graph, arrays))
    }
    pairs = zip(_flat(graph, given[0]), _flat(graph, jax.tree.leaves(result)), strict=True)
    changed = [(row, new) for row, (old, new) in enumerate(pairs) if new is not old]
    puts = [(Slot("next", at), new) for at, (_, new) in enumerate(changed)]
    nodes = [node for node in reach([new for _, new in puts]) if node.index not in lie]
    arguments = ", ".join(f"F *__restrict {name}" for name in names)
    body = cpp.function(f"static void {told.name}_next({arguments}, F *__restrict next)", nodes, lie, puts)
    rows = ", ".join(str(row) for row, _ in changed)
    return (
        f"{body}\n"
        f'extern "C" __attribute__((export_name("{told.name}"))) void {told.name}({arguments}) {{\n'
        f"static const short ROW[] = {{{rows}}};\n"
        f"F next[{len(changed)}];\n"
        f"{told.name}_next({', '.join(names)}, next);\n"
        f"for (int k = 0; k < {len(changed)}; k++) a[ROW[k]] = next[k];\n"
        "}\n"
    )


def _flat(graph: Graph, arrays: list[Entries]) -> list[Entry]:
    return [entry for one in arrays for entry in words(graph, one)]


def _forms(arrays: list[Entries]) -> list[Any]:
    return [(one.shape, one.flat[0].dtype) for one in arrays]
