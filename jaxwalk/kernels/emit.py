"""A graph's nodes as operations of JAX, on one array for each node."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from jaxwalk.kernels.graph import Entry, Node, known

OPERATIONS = {
    "add": lax.add, "sub": lax.sub, "mul": lax.mul, "div": lax.div, "min": lax.min, "max": lax.max,
    "neg": lax.neg, "abs": lax.abs, "sign": lax.sign, "sqrt": lax.sqrt, "sin": lax.sin, "cos": lax.cos,
    "exp": lax.exp, "log1p": lax.log1p, "asin": lax.asin, "atan2": lax.atan2, "floor": lax.floor,
    "round": lambda x: lax.round(x, lax.RoundingMethod.TO_NEAREST_EVEN), "pow": lax.pow, "rem": lax.rem,
    "lt": lax.lt, "le": lax.le, "gt": lax.gt, "ge": lax.ge, "eq": lax.eq, "ne": lax.ne,
    "and": lax.bitwise_and, "or": lax.bitwise_or, "xor": lax.bitwise_xor, "not": lax.bitwise_not,
    "shift_left": lax.shift_left, "shift_right_logical": lax.shift_right_logical, "is_finite": lax.is_finite,
    "select": lambda which, no, yes: lax.select(which, yes, no),
}  # fmt: skip


def emit(nodes: Iterable[Node], values: dict[int, jax.Array], shape: tuple[int, ...]) -> None:
    """Computes ``nodes``, in order.

    Args:
      values: of the nodes that these read, by index; those of ``nodes`` are added.
      shape: of all of them.
    """
    for node in nodes:
        args = [value(x, values, shape) for x in node.args]
        if node.op == "convert":
            values[node.index] = lax.convert_element_type(args[0], node.dtype)
        elif node.op == "bitcast":
            values[node.index] = lax.bitcast_convert_type(args[0], node.dtype)
        else:
            values[node.index] = OPERATIONS[node.op](*args)


def value(entry: Entry, values: dict[int, Any], shape: tuple[int, ...]) -> jax.Array:
    """The array [*shape] that an entry stands for."""
    return jnp.full(shape, entry, np.dtype(entry.dtype)) if known(entry) else values[entry.index]
