"""Arrays whose entries are numbers of a `Graph`: NumPy arrays of objects."""

from __future__ import annotations

from typing import Any

import jax
import numpy as np

from jaxwalk.kernels.graph import Entry, Graph, Unsupported, is_key, known

Entries = np.ndarray  # of objects, each a Node or a NumPy scalar


def inputs(graph: Graph, shapes: Any) -> Any:
    """New inputs of ``graph``, in the form of a tree of shapes and types."""

    def fresh(x: Any) -> Entries:
        result = np.empty(x.shape, object)
        for at in np.ndindex(x.shape):
            result[at] = graph.input(x.dtype)
        return result

    return jax.tree.map(fresh, shapes)


def constant(x: Any) -> Entries:
    """``x`` as an array of known entries."""
    x = np.asarray(x)
    result = np.empty(x.shape, object)
    for at in np.ndindex(x.shape):
        result[at] = x[at]
    return result


def numbers(x: Entries, dtype: Any) -> np.ndarray:
    """What an array holds whose entries are all known.

    Raises:
      Unsupported: they are not.
    """
    if not all(map(known, x.flat)):
        raise Unsupported("an index that is not constant")
    return np.array(x.tolist(), dtype).reshape(x.shape)


def words(graph: Graph, x: Entries) -> list[Entry]:
    """The numbers of ``x``; of keys, their words."""
    entries = [*x.flat]
    return [w for one in entries for w in graph.words(one)] if is_key(x.flat[0].dtype) else entries


def each(graph: Graph, op: str, out: Any, *args: Entries) -> Entries:
    """``op``, entry by entry, of arrays that broadcast to ``out``, which tells shape and type."""
    args = tuple(np.broadcast_to(x, out.shape) for x in args)
    result = np.empty(out.shape, object)
    for at in np.ndindex(out.shape):
        result[at] = graph.apply(op, tuple(x[at] for x in args), out.dtype)
    return result
