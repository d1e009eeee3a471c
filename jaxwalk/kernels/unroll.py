"""A JAX function of small arrays, unrolled into arithmetic on single numbers.

Gathers, transposes and the like move entries and cost nothing; structural zeros vanish with all that they
would have been multiplied with. What is left of a step of multibody dynamics is the arithmetic that somebody
would have written down by hand for this one mechanism, as code generators for robots do (Carpentier et al.
2019, "The Pinocchio C++ library").
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.extend import core as jex

from jaxwalk.kernels.graph import Entry, Graph, Unsupported, known

Objects = np.ndarray  # of entries


class Unroller:
    """Interprets a jaxpr on arrays of entries."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph

    def run(self, closed: jex.ClosedJaxpr, args: Sequence[Objects]) -> list[Objects]:
        """The results of ``closed`` for ``args``.

        Raises:
          Unsupported: an operation that cannot be unrolled.
        """
        values: dict[Any, Objects] = {}
        jaxpr = closed.jaxpr
        values.update(zip(jaxpr.constvars, map(constant, closed.consts), strict=True))
        values.update(zip(jaxpr.invars, args, strict=True))

        def read(atom: Any) -> Objects:
            return (
                constant(np.asarray(atom.val, atom.aval.dtype))
                if isinstance(atom, jex.Literal)
                else values[atom]
            )

        for eqn in needed(jaxpr):
            results = self._bind(eqn, [read(x) for x in eqn.invars])
            values.update(zip(eqn.outvars, results, strict=True))
        return [read(x) for x in jaxpr.outvars]

    def _bind(self, eqn: Any, args: list[Objects]) -> list[Objects]:
        name, params = eqn.primitive.name, eqn.params
        inner = next((params[k] for k in ("jaxpr", "call_jaxpr", "call") if k in params), None)
        if inner is not None and name in (
            "jit",
            "pjit",
            "custom_jvp_call",
            "custom_vmap_call",
            "closed_call",
        ):
            return self.run(inner if hasattr(inner, "jaxpr") else jex.ClosedJaxpr(inner, ()), args)
        if name in ("optimization_barrier", "copy", "copy_p"):
            return args
        if name == "unstack":
            rows = np.moveaxis(args[0], params["axis"], 0)
            return [rows[i, ...] for i in range(len(rows))]
        if name == "split":
            return np.split(args[0], np.cumsum(params["sizes"])[:-1], params["axis"])
        rule = getattr(self, "_" + name.replace("-", "_"), None)
        out = eqn.outvars[0].aval
        if rule is not None:
            results = rule(params, out, *args)
        elif name in _ELEMENTWISE:
            results = self._each(_ELEMENTWISE[name], out, *args)
        elif all(all(map(known, x.flat)) for x in args):
            return evaluated(eqn, args)
        else:
            raise Unsupported(f"{name} of what is not constant")
        if not isinstance(results, np.ndarray) or results.shape != out.shape:
            raise AssertionError(f"{name}: {np.shape(results)} in place of {out.shape}")
        return [results]

    def _each(self, op: str, out: Any, *args: Objects) -> Objects:
        args = tuple(np.broadcast_to(x, out.shape) for x in args)
        result = np.empty(out.shape, object)
        for at in np.ndindex(out.shape):
            result[at] = self.graph.apply(op, tuple(x[at] for x in args), out.dtype)
        return result

    # Movements.

    def _reshape(self, params: Any, out: Any, x: Objects) -> Objects:
        return x.reshape(out.shape)

    _squeeze = _reshape
    _expand_dims = _reshape

    def _slice(self, params: Any, out: Any, x: Objects) -> Objects:
        strides = params["strides"] or (1,) * x.ndim
        limits = zip(params["start_indices"], params["limit_indices"], strides, strict=True)
        return x[tuple(slice(*one) for one in limits)]

    def _transpose(self, params: Any, out: Any, x: Objects) -> Objects:
        return x.transpose(params["permutation"])

    def _rev(self, params: Any, out: Any, x: Objects) -> Objects:
        return np.flip(x, params["dimensions"])

    def _concatenate(self, params: Any, out: Any, *args: Objects) -> Objects:
        return np.concatenate(args, params["dimension"])

    def _stack(self, params: Any, out: Any, *args: Objects) -> Objects:
        return np.stack(args, params.get("axis", params.get("dimension", 0)))

    def _tile(self, params: Any, out: Any, x: Objects) -> Objects:
        return np.tile(x, params["reps"])

    def _broadcast_in_dim(self, params: Any, out: Any, x: Objects) -> Objects:
        shape = [1] * len(out.shape)
        for axis, to in enumerate(params["broadcast_dimensions"]):
            shape[to] = x.shape[axis]
        return np.broadcast_to(x.reshape(shape), out.shape)

    def _pad(self, params: Any, out: Any, x: Objects, filler: Objects) -> Objects:
        if any(low < 0 or high < 0 or inner for low, high, inner in params["padding_config"]):
            raise Unsupported("pad that crops or dilates")
        result = np.full(out.shape, filler[()], object)
        begins = [low for low, _, _ in params["padding_config"]]
        result[tuple(slice(b, b + n) for b, n in zip(begins, x.shape, strict=True))] = x
        return result

    def _select_n(self, params: Any, out: Any, which: Objects, *cases: Objects) -> Objects:
        if len(cases) != 2:
            raise Unsupported("select_n of more than two")
        return self._each("select", out, which, *cases)

    def _gather(self, params: Any, out: Any, x: Objects, where: Objects) -> Objects:
        places = _places(
            x.shape, values(where), params["dimension_numbers"], params["slice_sizes"], params["mode"]
        )
        filler = params["fill_value"]
        if filler is None:
            filler = np.nan if np.issubdtype(out.dtype, np.inexact) else 0
        entries = [*x.flat, out.dtype.type(filler)]
        result = np.empty(out.shape, object)
        for at in np.ndindex(out.shape):
            result[at] = entries[places[at]]
        return result

    def _dynamic_slice(self, params: Any, out: Any, x: Objects, *starts: Objects) -> Objects:
        for axis, (start, size) in enumerate(zip(starts, params["slice_sizes"], strict=True)):
            x = self._sliced(x, axis, start[()], size)
        return x

    def _sliced(self, x: Objects, axis: int, start: Entry, size: int) -> Objects:
        """``size`` entries of ``axis``, from ``start`` on, which may be known only as the program runs."""
        last = x.shape[axis] - size
        parts = [np.take(x, range(at, at + size), axis) for at in range(last + 1)]
        if known(start):
            return parts[min(max(int(start), 0), last)]
        found = parts[0]
        for at in range(1, last + 1):
            there = np.empty((), object)
            there[()] = self.graph.apply("ge", (start, start.dtype.type(at)), np.dtype(bool))
            like = jax.ShapeDtypeStruct(found.shape, _dtype(x.flat[0]))
            found = self._each("select", like, there, found, parts[at])
        return found

    def _scattered(self, params: Any, x: Objects, where: Objects, new: Objects, op: str | None) -> Objects:
        numbers = params["dimension_numbers"]
        inserted = {*numbers.inserted_window_dims, *numbers.operand_batching_dims}
        window = iter(numbers.update_window_dims)
        sizes = tuple(1 if axis in inserted else new.shape[next(window)] for axis in range(x.ndim))
        like = jax.lax.GatherDimensionNumbers(
            offset_dims=numbers.update_window_dims,
            collapsed_slice_dims=numbers.inserted_window_dims,
            start_index_map=numbers.scatter_dims_to_operand_dims,
            operand_batching_dims=numbers.operand_batching_dims,
            start_indices_batching_dims=numbers.scatter_indices_batching_dims,
        )
        places = _places(x.shape, values(where), like, sizes, params["mode"])
        entries = [*x.flat]
        for at in np.ndindex(new.shape):
            place = places[at]
            if place >= 0:
                entries[place] = (
                    new[at]
                    if op is None
                    else self.graph.apply(op, (entries[place], new[at]), _dtype(entries[place]))
                )
        result = np.empty(len(entries), object)
        result[:] = entries
        return result.reshape(x.shape)

    def _scatter(self, params: Any, out: Any, *args: Objects) -> Objects:
        return self._scattered(params, *args, None)

    def _scatter_add(self, params: Any, out: Any, *args: Objects) -> Objects:
        return self._scattered(params, *args, "add")

    def _scatter_mul(self, params: Any, out: Any, *args: Objects) -> Objects:
        return self._scattered(params, *args, "mul")

    # Arithmetic.

    def _convert_element_type(self, params: Any, out: Any, x: Objects) -> Objects:
        return self._each("convert", out, x)

    def _integer_pow(self, params: Any, out: Any, x: Objects) -> Objects:
        power, result = params["y"], x
        for _ in range(abs(power) - 1):
            result = self._each("mul", out, result, x)
        if power == 0:
            return constant(np.ones(out.shape, out.dtype))
        return result if power > 0 else self._each("div", out, constant(out.dtype.type(1)), result)

    def _square(self, params: Any, out: Any, x: Objects) -> Objects:
        return self._each("mul", out, x, x)

    def _clamp(self, params: Any, out: Any, low: Objects, x: Objects, high: Objects) -> Objects:
        return self._each("min", out, self._each("max", out, low, x), high)

    def _reduced(self, op: str, first: Any, params: Any, out: Any, x: Objects) -> Objects:
        axes = params["axes"]
        kept = [axis for axis in range(x.ndim) if axis not in axes]
        rows = x.transpose(*kept, *axes).reshape(*out.shape, -1)
        result = np.empty(out.shape, object)
        for at in np.ndindex(out.shape):
            total = out.dtype.type(first)
            for entry in rows[at]:
                total = entry if total is None else self.graph.apply(op, (total, entry), out.dtype)
            result[at] = total
        return result

    def _reduce_sum(self, params: Any, out: Any, x: Objects) -> Objects:
        return self._reduced("add", 0, params, out, x)

    def _reduce_max(self, params: Any, out: Any, x: Objects) -> Objects:
        return self._reduced("max", -np.inf, params, out, x)

    def _reduce_min(self, params: Any, out: Any, x: Objects) -> Objects:
        return self._reduced("min", np.inf, params, out, x)

    def _reduce_and(self, params: Any, out: Any, x: Objects) -> Objects:
        return self._reduced("and", True, params, out, x)

    def _reduce_or(self, params: Any, out: Any, x: Objects) -> Objects:
        return self._reduced("or", False, params, out, x)

    def _dot_general(self, params: Any, out: Any, left: Objects, right: Objects) -> Objects:
        (left_sum, right_sum), (left_batch, right_batch) = params["dimension_numbers"]
        left, right = (  # its operands may be of other types than its result
            self._each("convert", jax.ShapeDtypeStruct(x.shape, out.dtype), x) for x in (left, right)
        )
        a, kept_a = _arranged(left, left_batch, left_sum)
        b, kept_b = _arranged(right, right_batch, right_sum)
        shape = (a.shape[0], a.shape[1], b.shape[1])
        result = np.empty(shape, object)
        for batch, i, j in np.ndindex(shape):
            total: Entry = out.dtype.type(0)
            for p, q in zip(a[batch, i], b[batch, j], strict=True):
                product = self.graph.apply("mul", (p, q), out.dtype)
                total = self.graph.apply("add", (total, product), out.dtype)
            result[batch, i, j] = total
        return result.reshape(*(left.shape[axis] for axis in left_batch), *kept_a, *kept_b)


_CALLS = ("jit", "pjit", "custom_jvp_call", "custom_vmap_call", "closed_call")
_ELEMENTWISE = {
    name: name
    for name in (
        "add", "sub", "mul", "div", "min", "max", "neg", "abs", "sign", "sqrt", "sin", "cos", "exp", "asin",
        "atan2", "floor", "pow", "rem", "lt", "le", "gt", "ge", "eq", "ne", "and", "or", "not", "is_finite",
    )
} | {"add_any": "add"}  # fmt: skip


def unrolled(graph: Graph, function: Callable[..., Any], *args: Any) -> Any:
    """``function`` of trees of entries; it is traced for their shapes and types.

    Args:
      args: trees of arrays of entries, by `inputs` or `constant`.

    Returns:
      Its results, a tree of arrays of entries.

    Raises:
      Unsupported: it does what cannot be unrolled.
    """
    leaves, tree = jax.tree.flatten(args)
    like = [jax.ShapeDtypeStruct(x.shape, _dtype(x.flat[0]) if x.size else np.float32) for x in leaves]
    closed, shape = jax.make_jaxpr(lambda *x: function(*jax.tree.unflatten(tree, x)), return_shape=True)(
        *like
    )
    return jax.tree.unflatten(jax.tree.structure(shape), Unroller(graph).run(closed, leaves))


def inputs(graph: Graph, shapes: Any) -> Any:
    """New inputs of ``graph``, in the form of a tree of shapes and types."""

    def fresh(x: Any) -> Objects:
        result = np.empty(x.shape, object)
        for at in np.ndindex(x.shape):
            result[at] = graph.input(x.dtype)
        return result

    return jax.tree.map(fresh, shapes)


def constant(x: Any) -> Objects:
    """``x`` as an array of known entries."""
    x = np.asarray(x)
    result = np.empty(x.shape, object)
    for at in np.ndindex(x.shape):
        result[at] = x[at]
    return result


def values(x: Objects) -> np.ndarray:
    """The numbers of an array whose entries are all known.

    Raises:
      Unsupported: they are not.
    """
    if not all(map(known, x.flat)):
        raise Unsupported("an index that is not constant")
    return np.array(x.tolist(), _dtype(x.flat[0]) if x.size else np.float32).reshape(x.shape)


def needed(jaxpr: Any) -> list[Any]:
    """Its equations, without those whose results nobody reads."""
    wanted = {x for x in jaxpr.outvars if not isinstance(x, jex.Literal)}
    kept = []
    for eqn in reversed(jaxpr.eqns):
        if any(x in wanted for x in eqn.outvars):
            kept.append(eqn)
            wanted |= {x for x in eqn.invars if not isinstance(x, jex.Literal)}
    return kept[::-1]


def evaluated(eqn: Any, args: list[Objects]) -> list[Objects]:
    """An equation of constants, by JAX itself."""
    with jax.ensure_compile_time_eval():
        known_args = [jnp.asarray(values(x), v.aval.dtype) for x, v in zip(args, eqn.invars, strict=True)]
        results = eqn.primitive.bind(*known_args, **eqn.params)
    results = results if eqn.primitive.multiple_results else [results]
    return [constant(x) for x in results]


def _dtype(entry: Entry) -> Any:
    return entry.dtype


def _places(shape: tuple[int, ...], where: np.ndarray, numbers: Any, sizes: Any, mode: Any) -> np.ndarray:
    """For each entry that `jax.lax.gather` takes, its place in the flattened operand; -1: outside of it."""
    ids, room = np.arange(math.prod(shape)).reshape(shape), np.subtract(shape, sizes)
    dropped = (*numbers.collapsed_slice_dims, *numbers.operand_batching_dims)
    rows = where.shape[:-1]
    taken = np.empty((*rows, *np.delete(sizes, dropped)), int)
    batching = [*zip(numbers.operand_batching_dims, numbers.start_indices_batching_dims, strict=True)]
    for row in np.ndindex(rows):
        start = np.zeros(len(shape), int)
        start[[*numbers.start_index_map]] = where[row]
        for axis, of_row in batching:
            start[axis] = row[of_row]
        if mode == jax.lax.GatherScatterMode.FILL_OR_DROP and ((start < 0) | (start > room)).any():
            taken[row] = -1
            continue
        begins = np.clip(start, 0, room)
        taken[row] = ids[tuple(slice(b, b + n) for b, n in zip(begins, sizes, strict=True))].squeeze(dropped)
    window = range(len(rows), taken.ndim)
    return np.moveaxis(taken, [*window], [*numbers.offset_dims])


def _arranged(x: Objects, batch: Sequence[int], summed: Sequence[int]) -> tuple[Objects, list[int]]:
    """``x`` as [batch, kept, summed]; and the kept axes' sizes."""
    kept = [axis for axis in range(x.ndim) if axis not in (*batch, *summed)]
    sizes = [math.prod(x.shape[axis] for axis in axes) for axes in (batch, kept, summed)]
    return x.transpose(*batch, *kept, *summed).reshape(sizes), [x.shape[axis] for axis in kept]
