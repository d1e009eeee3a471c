"""What JAX's operations do to arrays of entries. Movements cost nothing; arithmetic goes into the graph.

A rule takes the graph, the operation's parameters, the result's shape and type, and the operands.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import jax
import numpy as np

from jaxwalk.kernels import places, randoms
from jaxwalk.kernels.entries import Entries, constant, each, numbers
from jaxwalk.kernels.graph import OPERATIONS, Entry, Graph, Unsupported, known


def _reshape(graph: Graph, params: Any, out: Any, x: Entries) -> Entries:
    return x.reshape(out.shape)


def _slice(graph: Graph, params: Any, out: Any, x: Entries) -> Entries:
    strides = params["strides"] or (1,) * x.ndim
    limits = zip(params["start_indices"], params["limit_indices"], strides, strict=True)
    return x[tuple(slice(*one) for one in limits)]


def _transpose(graph: Graph, params: Any, out: Any, x: Entries) -> Entries:
    return x.transpose(params["permutation"])


def _rev(graph: Graph, params: Any, out: Any, x: Entries) -> Entries:
    return np.flip(x, params["dimensions"])


def _concatenate(graph: Graph, params: Any, out: Any, *args: Entries) -> Entries:
    return np.concatenate(args, params["dimension"])


def _stack(graph: Graph, params: Any, out: Any, *args: Entries) -> Entries:
    return np.stack(args, params.get("axis", params.get("dimension", 0)))


def _unstack(graph: Graph, params: Any, out: Any, x: Entries) -> list[Entries]:
    rows = np.moveaxis(x, params["axis"], 0)
    return [rows[i, ...] for i in range(len(rows))]


def _split(graph: Graph, params: Any, out: Any, x: Entries) -> list[Entries]:
    return np.split(x, np.cumsum(params["sizes"])[:-1], params["axis"])


def _tile(graph: Graph, params: Any, out: Any, x: Entries) -> Entries:
    return np.tile(x, params["reps"])


def _broadcast_in_dim(graph: Graph, params: Any, out: Any, x: Entries) -> Entries:
    shape = [1] * len(out.shape)
    for axis, to in enumerate(params["broadcast_dimensions"]):
        shape[to] = x.shape[axis]
    return np.broadcast_to(x.reshape(shape), out.shape)


def _pad(graph: Graph, params: Any, out: Any, x: Entries, filler: Entries) -> Entries:
    if any(low < 0 or high < 0 or inner for low, high, inner in params["padding_config"]):
        raise Unsupported("pad that crops or dilates")
    result = np.full(out.shape, filler[()], object)
    begins = [low for low, _, _ in params["padding_config"]]
    result[tuple(slice(b, b + n) for b, n in zip(begins, x.shape, strict=True))] = x
    return result


def _select_n(graph: Graph, params: Any, out: Any, which: Entries, *cases: Entries) -> Entries:
    if len(cases) != 2 or (which.size and which.flat[0].dtype != np.bool_):
        raise Unsupported("select_n by a number")
    return each(graph, "select", out, which, *cases)


def _gather(graph: Graph, params: Any, out: Any, x: Entries, where: Entries) -> Entries:
    at = places.of_gather(
        x.shape, numbers(where, int), params["dimension_numbers"], params["slice_sizes"], params["mode"]
    )
    filler = params["fill_value"]
    entries = [*x.flat, out.dtype.type(np.nan if filler is None and out.dtype.kind == "f" else filler or 0)]
    result = np.empty(out.shape, object)
    for one in np.ndindex(out.shape):
        result[one] = entries[at[one]]
    return result


def _scatter(
    graph: Graph, params: Any, out: Any, x: Entries, where: Entries, new: Entries, op: str | None = None
) -> Entries:
    if op is None and params["update_jaxpr"] is not None:
        raise Unsupported("scatter by a function")
    at = places.of_scatter(
        x.shape, new.shape, numbers(where, int), params["dimension_numbers"], params["mode"]
    )
    result = np.empty(x.size, object)
    result[:] = [*x.flat]
    for one in np.ndindex(new.shape):
        place = at[one]
        if place >= 0:
            result[place] = new[one] if op is None else graph.apply(op, (result[place], new[one]), out.dtype)
    return result.reshape(x.shape)


def _dynamic_slice(graph: Graph, params: Any, out: Any, x: Entries, *starts: Entries) -> Entries:
    for axis, (start, size) in enumerate(zip(starts, params["slice_sizes"], strict=True)):
        x = _sliced(graph, x, axis, start[()], size)
    return x


def _sliced(graph: Graph, x: Entries, axis: int, start: Entry, size: int) -> Entries:
    """``size`` entries of ``axis``, from ``start`` on, which may be known only as the program runs."""
    last = x.shape[axis] - size
    parts = [np.take(x, range(at, at + size), axis) for at in range(last + 1)]
    if known(start):
        return parts[min(max(int(start), 0), last)]
    found = parts[0]
    for at in range(1, last + 1):
        there = np.empty((), object)
        there[()] = graph.apply("ge", (start, start.dtype.type(at)), np.dtype(bool))
        found = each(
            graph, "select", jax.ShapeDtypeStruct(found.shape, x.flat[0].dtype), there, found, parts[at]
        )
    return found


def _convert(graph: Graph, params: Any, out: Any, x: Entries) -> Entries:
    return each(graph, "convert", out, x)


def _integer_pow(graph: Graph, params: Any, out: Any, x: Entries) -> Entries:
    power, result = params["y"], x
    if power == 0:
        return constant(np.ones(out.shape, out.dtype))
    for _ in range(abs(power) - 1):
        result = each(graph, "mul", out, result, x)
    return result if power > 0 else each(graph, "div", out, constant(out.dtype.type(1)), result)


def _square(graph: Graph, params: Any, out: Any, x: Entries) -> Entries:
    return each(graph, "mul", out, x, x)


def _bitcast(graph: Graph, params: Any, out: Any, x: Entries) -> Entries:
    if x.size and x.flat[0].dtype.itemsize != out.dtype.itemsize:
        raise Unsupported("bitcast_convert_type to another width")
    return each(graph, "bitcast", out, x)


def _round(graph: Graph, params: Any, out: Any, x: Entries) -> Entries:
    if params["rounding_method"] != jax.lax.RoundingMethod.TO_NEAREST_EVEN:
        raise Unsupported("round of halves away from nought")
    return each(graph, "round", out, x)


def _clamp(graph: Graph, params: Any, out: Any, low: Entries, x: Entries, high: Entries) -> Entries:
    return each(graph, "min", out, each(graph, "max", out, low, x), high)


_OF_NOTHING = {"add": 0, "and": True, "or": False}


def _reduced(graph: Graph, params: Any, out: Any, x: Entries, op: str) -> Entries:
    axes = params["axes"]
    kept = [axis for axis in range(x.ndim) if axis not in axes]
    if not x.size:
        if op not in _OF_NOTHING:
            raise Unsupported(f"{op} of nothing")
        return constant(np.full(out.shape, _OF_NOTHING[op], out.dtype))
    rows = x.transpose(*kept, *axes).reshape(*out.shape, -1)
    result = np.empty(out.shape, object)
    for at in np.ndindex(out.shape):
        total, *others = rows[at]
        for entry in others:
            total = graph.apply(op, (total, entry), out.dtype)
        result[at] = total
    return result


def _dot_general(graph: Graph, params: Any, out: Any, left: Entries, right: Entries) -> Entries:
    (left_sum, right_sum), (left_batch, right_batch) = params["dimension_numbers"]
    left, right = (  # its operands may be of other types than its result
        each(graph, "convert", jax.ShapeDtypeStruct(x.shape, out.dtype), x) for x in (left, right)
    )
    a, b = _arranged(left, left_batch, left_sum), _arranged(right, right_batch, right_sum)
    result = np.empty((a.shape[0], a.shape[1], b.shape[1]), object)
    for batch, i, j in np.ndindex(result.shape):
        total: Entry = out.dtype.type(0)
        for p, q in zip(a[batch, i], b[batch, j], strict=True):
            total = graph.apply("add", (total, graph.apply("mul", (p, q), out.dtype)), out.dtype)
        result[batch, i, j] = total
    return result.reshape(out.shape)


def _arranged(x: Entries, batch: Sequence[int], summed: Sequence[int]) -> Entries:
    """``x`` as [batch, kept, summed]."""
    kept = [axis for axis in range(x.ndim) if axis not in (*batch, *summed)]
    sizes = [math.prod(x.shape[axis] for axis in axes) for axes in (batch, kept, summed)]
    return x.transpose(*batch, *kept, *summed).reshape(sizes)


def _elementwise(graph: Graph, params: Any, out: Any, *args: Entries, op: str) -> Entries:
    return each(graph, op, out, *args)


def _same(graph: Graph, params: Any, out: Any, *args: Entries) -> list[Entries]:
    return [*args]


RULES: dict[str, Callable[..., Any]] = {
    **{name: partial(_elementwise, op=name) for name in OPERATIONS},
    "add_any": partial(_elementwise, op="add"),
    "reshape": _reshape, "squeeze": _reshape, "expand_dims": _reshape, "slice": _slice, "rev": _rev,
    "transpose": _transpose, "concatenate": _concatenate, "stack": _stack, "unstack": _unstack,
    "split": _split, "tile": _tile, "broadcast_in_dim": _broadcast_in_dim, "pad": _pad,
    "bitcast_convert_type": _bitcast, "round": _round, "erf_inv": randoms.erf_inv,
    "random_fold_in": randoms.fold_in, "random_bits": randoms.bits, "random_split": randoms.split,
    "random_wrap": randoms.wrap, "random_unwrap": randoms.unwrap,
    "select_n": _select_n, "gather": _gather, "dynamic_slice": _dynamic_slice,
    "scatter": _scatter, "scatter-add": partial(_scatter, op="add"),
    "scatter-mul": partial(_scatter, op="mul"),
    "convert_element_type": _convert, "integer_pow": _integer_pow, "square": _square, "clamp": _clamp,
    "reduce_sum": partial(_reduced, op="add"), "reduce_max": partial(_reduced, op="max"),
    "reduce_min": partial(_reduced, op="min"), "reduce_and": partial(_reduced, op="and"),
    "reduce_or": partial(_reduced, op="or"), "dot_general": _dot_general,
    "optimization_barrier": _same, "copy": _same, "copy_p": _same,
    # Of where arrays lie, which one walker's numbers do not know.
    "reshard": _same, "pvary": _same, "pcast": _same, "mesh_cast": _same, "sharding_constraint": _same,
}  # fmt: skip
"""By the primitive's name. A rule gives the result, or a list of all results."""
