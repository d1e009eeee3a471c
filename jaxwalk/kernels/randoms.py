"""What JAX's random numbers are made of: Threefry's bits, and the normal distribution's quantiles.

The bits are JAX's own, one for one (Salmon et al. 2011, "Parallel random numbers: as easy as 1, 2, 3"; a key
of two words, twenty rounds, counters as with ``jax_threefry_partitionable``).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import jax
import numpy as np

from jaxwalk.kernels.entries import Entries, constant, each
from jaxwalk.kernels.graph import Entry, Graph, Unsupported
from jaxwalk.kernels.settings import jax_setting

_WORD = np.dtype(np.uint32)
_ROTATIONS = ((13, 15, 26, 6), (17, 29, 16, 24))
_PARITY = np.uint32(0x1BD11BDA)

# Giles 2010, "Approximating the erfinv function", single precision: of w - 2.5 up to w = 5, of sqrt(w) - 3.
_NEAR = (
    2.81022636e-08, 3.43273939e-07, -3.5233877e-06, -4.39150654e-06, 0.00021858087, -0.00125372503,
    -0.00417768164, 0.246640727, 1.50140941,
)  # fmt: skip
_FAR = (
    -0.000200214257, 0.000100950558, 0.00134934322, -0.00367342844, 0.00573950773, -0.0076224613,
    0.00943887047, 1.00167406, 2.83297682,
)  # fmt: skip


def threefry(graph: Graph, key: tuple[Entry, Entry], counter: tuple[Entry, Entry]) -> tuple[Entry, Entry]:
    """The two words that Threefry-2x32 makes of two under ``key``."""

    def add(a: Entry, b: Entry) -> Entry:
        return graph.apply("add", (a, b), _WORD)

    def xor(a: Entry, b: Entry) -> Entry:
        return graph.apply("xor", (a, b), _WORD)

    def rotated(x: Entry, bits: int) -> Entry:
        high = graph.apply("shift_left", (x, np.uint32(bits)), _WORD)
        return graph.apply(
            "or", (high, graph.apply("shift_right_logical", (x, np.uint32(32 - bits)), _WORD)), _WORD
        )

    schedule = (*key, xor(xor(*key), _PARITY))
    a, b = add(counter[0], key[0]), add(counter[1], key[1])
    for turn in range(5):
        for bits in _ROTATIONS[turn % 2]:
            a = add(a, b)
            b = xor(a, rotated(b, bits))
        a = add(a, schedule[(turn + 1) % 3])
        b = add(add(b, schedule[(turn + 2) % 3]), np.uint32(turn + 1))
    return a, b


def _checked(dtype: Any) -> None:
    if dtype.name != "key<fry>" or not jax_setting("jax_threefry_partitionable"):
        raise Unsupported(f"random numbers of {dtype.name}, or counted as JAX did before")


def fold_in(graph: Graph, params: Any, out: Any, keys: Entries, data: Entries) -> Entries:
    """``jax.random.fold_in``."""
    _checked(out.dtype)
    keys, data = np.broadcast_to(keys, out.shape), np.broadcast_to(data, out.shape)
    result = np.empty(out.shape, object)
    for at in np.ndindex(out.shape):
        words = threefry(graph, graph.words(keys.item(at)), (np.uint32(0), data[at]))
        result[at] = graph.key(words, out.dtype)
    return result


def _counted(graph: Graph, key: Entry, shape: Sequence[int]) -> list[tuple[Entry, Entry]]:
    """Threefry of 0, 1, 2, ..., one for each element of ``shape``."""
    words = graph.words(key)
    return [threefry(graph, words, (np.uint32(0), np.uint32(i))) for i in range(math.prod(shape))]


def bits(graph: Graph, params: Any, out: Any, keys: Entries) -> Entries:
    """``jax.random.bits``, 32 at a time."""
    if params["bit_width"] != 32:
        raise Unsupported(f"{params['bit_width']} random bits")
    shape = params["shape"]
    result = np.empty((*keys.shape, math.prod(shape)), object)
    for at in np.ndindex(keys.shape):
        _checked(keys[at].dtype)
        result[at] = [graph.apply("xor", pair, _WORD) for pair in _counted(graph, keys[at], shape)]
    return result.reshape(out.shape)


def split(graph: Graph, params: Any, out: Any, keys: Entries) -> Entries:
    """``jax.random.split``."""
    _checked(out.dtype)
    shape = params["shape"]
    result = np.empty((*keys.shape, math.prod(shape)), object)
    for at in np.ndindex(keys.shape):
        result[at] = [graph.key(pair, out.dtype) for pair in _counted(graph, keys[at], shape)]
    return result.reshape(out.shape)


def wrap(graph: Graph, params: Any, out: Any, words: Entries) -> Entries:
    """``jax.random.wrap_key_data``."""
    _checked(out.dtype)
    result = np.empty(out.shape, object)
    for at in np.ndindex(out.shape):
        result[at] = graph.key(tuple(words[at]), out.dtype)
    return result


def unwrap(graph: Graph, params: Any, out: Any, keys: Entries) -> Entries:
    """``jax.random.key_data``."""
    result = np.empty(out.shape, object)
    for at in np.ndindex(keys.shape):
        result[at] = graph.words(keys.item(at))
    return result


def erf_inv(graph: Graph, params: Any, out: Any, x: Entries) -> Entries:
    """``jax.lax.erf_inv``, by the polynomials that XLA uses in single precision."""
    kind = out.dtype
    if kind != np.float32:
        raise Unsupported(f"erf_inv of {kind}")

    def number(value: float) -> Entries:
        return constant(np.full(out.shape, value, kind))

    def of(op: str, *args: Entries, like: Any = out) -> Entries:
        return each(graph, op, like, *args)

    def polynomial(coefficients: Sequence[float], at: Entries) -> Entries:
        total = number(coefficients[0])
        for one in coefficients[1:]:
            total = of("add", of("mul", total, at), number(one))
        return total

    w = of("neg", of("log1p", of("mul", x, of("neg", x))))
    near = of("lt", w, number(5.0), like=jax.ShapeDtypeStruct(out.shape, np.bool_))
    inner = polynomial(_NEAR, of("sub", w, number(2.5)))
    outer = polynomial(_FAR, of("sub", of("sqrt", w), number(3.0)))
    result = of("mul", of("select", near, outer, inner), x)
    # At the ends of its domain.
    end = of("eq", of("abs", x), number(1.0), like=jax.ShapeDtypeStruct(out.shape, np.bool_))
    return of("select", end, result, of("mul", x, number(np.inf)))
