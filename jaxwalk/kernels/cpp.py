"""A graph's nodes as C++ on vectors of walkers; `native/lanes.h` and `native/maths.h` have the operations."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

import numpy as np

from jaxwalk.kernels.graph import Entry, Node, Unsupported, known

_INFIX = {"add": "+", "sub": "-", "mul": "*"}
_BITS = {"and": "&", "or": "|", "xor": "^"}
_LOGIC = {"and": "both", "or": "either", "xor": "unlike", "not": "opposite", "min": "both", "max": "either"}
_ORDER = ("lt", "le", "gt", "ge")
_CALLS = {
    "div": "quotient", "rem": "remainder", "min": "least", "max": "greatest", "neg": "negative",
    "abs": "magnitude", "sign": "sign", "sqrt": "root", "sin": "sine", "cos": "cosine", "exp": "exponential",
    "log1p": "log_of_one_more", "asin": "arcsine", "atan2": "arctangent", "pow": "power", "floor": "floored",
    "round": "rounded", "is_finite": "finite",
    **{name: name for name in (*_ORDER, "eq", "ne")},
}  # fmt: skip
OPERATIONS = frozenset({*_INFIX, *_BITS, *_LOGIC, *_CALLS, "shift_left", "shift_right_logical"})
"""All of `graph.OPERATIONS`."""


class Slot(NamedTuple):
    """Where a number lies: one vector of an array."""

    array: str
    row: int


def letter(dtype: np.dtype) -> str:
    """The type in `lanes.h`.

    Raises:
      Unsupported: there is none.
    """
    dtype = np.dtype(dtype)
    if dtype != np.bool_ and (dtype.itemsize != 4 or dtype.kind not in "fiu"):
        raise Unsupported(f"numbers of type {dtype}")
    return {"f": "F", "i": "I", "u": "U", "b": "B"}[dtype.kind]


def literal(entry: Entry) -> str:
    """A constant of one walker."""
    kind = entry.dtype.kind
    if kind == "b":
        return "true" if entry else "false"
    if kind == "u":
        return f"{int(entry)}u"
    if kind == "i":
        return f"(int32_t){int(entry)}LL"
    if not np.isfinite(entry):
        return "NAN" if np.isnan(entry) else "-INFINITY" if entry < 0 else "INFINITY"
    digits = repr(float(entry))
    return f"{digits}f" if "." in digits or "e" in digits else f"{digits}.0f"


def vector(entry: Entry) -> str:
    """A constant of all walkers."""
    call = {"f": "f", "i": "i", "u": "u", "b": "truth"}[entry.dtype.kind]
    return f"{call}({literal(entry)})"


def loaded(slot: Slot, dtype: np.dtype) -> str:
    """What lies in ``slot``, as its own type."""
    place, kind = f"{slot.array}[{slot.row}]", letter(dtype)
    if kind == "F":
        return place
    return f"ne(bits<I>({place}), i(0))" if kind == "B" else f"bits<{kind}>({place})"


def stored(slot: Slot, value: str, dtype: np.dtype) -> str:
    """The statement that puts ``value`` into ``slot``."""
    kind = letter(dtype)
    whole = f"integer({value})" if kind == "B" else value
    return f"{slot.array}[{slot.row}] = {whole if kind == 'F' else f'bits<F>({whole})'};"


def function(
    declaration: str,
    nodes: Iterable[Node],
    sources: Mapping[int, Slot],
    results: Iterable[tuple[Slot, Entry]],
    opening: str = "",
) -> str:
    """A function that computes ``nodes``, in order, and puts ``results`` where they belong.

    Args:
      declaration: as C++ has it. opening: statements before all others.
      sources: where the numbers lie that it is given, by the node's index.
    """
    lines, done = [], set()
    wanted: dict[int, list[tuple[Slot, Entry]]] = {}
    for slot, entry in results:
        wanted.setdefault(id(entry) if known(entry) else entry.index, []).append((slot, entry))

    def reference(entry: Entry) -> str:
        if known(entry):
            return vector(entry)
        return loaded(sources[entry.index], entry.dtype) if entry.index in sources else f"x{entry.index}"

    for node in nodes:
        lines.append(f"const {letter(node.dtype)} x{node.index} = {expression(node, reference)};")
        lines += [stored(slot, f"x{node.index}", x.dtype) for slot, x in wanted.get(node.index, ())]
        done.add(node.index)
    for key, puts in wanted.items():
        if key not in done:
            lines += [stored(slot, reference(entry), entry.dtype) for slot, entry in puts]
    return "\n".join([declaration, "{", opening, *lines, "}", ""])


def expression(node: Node, reference: Callable[[Entry], str]) -> str:
    """``node`` in terms of its arguments."""
    op, args, kind = node.op, node.args, np.dtype(node.dtype).kind
    if (op in _ORDER and args[0].dtype == np.bool_) or (op == "pow" and args[1].dtype.kind != "f"):
        raise Unsupported(f"{op} of {args[-1].dtype}")
    told = [reference(x) for x in args]
    if op == "convert":
        return _converted(told[0], args[0].dtype, node.dtype)
    if op == "bitcast":
        return f"bits<{letter(node.dtype)}>({told[0]})"
    if op == "select":
        if kind == "b":
            return f"either(both({told[0]}, {told[2]}), both(opposite({told[0]}), {told[1]}))"
        return f"select({', '.join(told)})"
    if op.startswith("shift"):
        return f"({told[0]} {'<<' if op == 'shift_left' else '>>'} {int(args[1])})"
    if kind == "b" and op in _LOGIC:
        return f"{_LOGIC[op]}({', '.join(told)})"
    if op in _BITS:
        return f"({told[0]} {_BITS[op]} {told[1]})"
    if op == "not":
        return f"(~{told[0]})"
    if op in _INFIX:
        return f"({told[0]} {_INFIX[op]} {told[1]})"
    if op in ("min", "max") and kind == "f" and known(args[1]) and not np.isnan(args[1]):
        return f"{_CALLS[op]}_known({told[0]}, {literal(args[1])})"
    if op in ("eq", "ne") and args[0].dtype.kind == "b":
        unlike = f"unlike({', '.join(told)})"
        return unlike if op == "ne" else f"opposite({unlike})"
    return f"{_CALLS[op]}({', '.join(told)})"


def _converted(told: str, source: np.dtype, target: np.dtype) -> str:
    old, new = np.dtype(source).kind, np.dtype(target).kind
    if old == "b":
        return {"f": f"floating_truth({told})", "i": f"integer({told})", "u": f"bits<U>(integer({told}))"}[
            new
        ]
    if new == "b":
        return f"ne({told}, {letter(source).lower()}(0))"
    if new == "f":
        return f"floating({told})"
    if old == "f":
        return f"whole({told})" if new == "i" else f"whole_unsigned({told})"
    return f"bits<{letter(target)}>({told})"
