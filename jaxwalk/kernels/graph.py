"""Arithmetic on single numbers as a graph: constants folded, what is equal computed once.

An entry of an array is a NumPy scalar, known as the program is built, or a `Node`, known as it runs. Arrays
are NumPy's, of objects. A random key is one entry, too, made of its two words.
"""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np


class Node:
    """The result of one operation.

    Attributes:
      op: its name, as in `jax.lax`; "input" of what comes from outside; "key" of two words, "word" of a key.
      args: Nodes and NumPy scalars; of an input, its number.
      dtype: of the result; an input may be one of JAX's random keys.
      index: its place in the order of making, in which arguments precede.
    """

    __slots__ = ("args", "dtype", "index", "op")

    def __init__(self, op: str, args: tuple[Any, ...], dtype: Any, index: int) -> None:
        self.op, self.args, self.dtype, self.index = op, args, dtype, index

    def __repr__(self) -> str:
        return f"%{self.index}"


Entry = Any  # a Node or a NumPy scalar


class Unsupported(ValueError):
    """A function that cannot be unrolled: an operation of it has no rule, or its arrays are empty."""


def known(entry: Entry) -> bool:
    """Whether ``entry`` is a constant."""
    return not isinstance(entry, Node)


ARITHMETIC = frozenset("add sub mul div min max neg sqrt sin cos exp log1p asin atan2 pow".split())
"""What counts as a floating-point operation."""
_COMMUTE = frozenset("add mul min max and or xor eq ne".split())

OPERATIONS: dict[str, Any] = {
    "add": np.add, "sub": np.subtract, "mul": np.multiply, "div": np.divide,
    "min": np.minimum, "max": np.maximum, "neg": np.negative, "abs": np.abs, "sign": np.sign,
    "sqrt": np.sqrt, "sin": np.sin, "cos": np.cos, "exp": np.exp, "log1p": np.log1p, "asin": np.arcsin,
    "atan2": np.arctan2, "floor": np.floor, "round": np.round, "pow": np.power, "rem": np.fmod,
    "lt": np.less, "le": np.less_equal, "gt": np.greater, "ge": np.greater_equal,
    "eq": np.equal, "ne": np.not_equal,
    "and": np.bitwise_and, "or": np.bitwise_or, "xor": np.bitwise_xor, "not": np.invert,
    "shift_left": np.left_shift, "shift_right_logical": np.right_shift, "is_finite": np.isfinite,
}  # fmt: skip
"""All that a graph is made of, but for ``convert``, ``bitcast``, ``select`` and keys, and how constants are
computed. ``round``: halves to even. Shifts are of unsigned numbers, by a constant."""


class Graph:
    """Makes nodes; the same operation on the same arguments is one node.

    Numbers are taken to be finite: 0 x, x - x and 0 / x are 0, where JAX may have NaN, so that structural
    zeros vanish.
    """

    def __init__(self) -> None:
        self.nodes: list[Node] = []
        self._made: dict[Any, Node] = {}

    def input(self, dtype: Any) -> Node:
        """One more number from outside."""
        return self._node("input", (len(self.nodes),), dtype)

    def apply(self, op: str, args: tuple[Entry, ...], dtype: Any) -> Entry:
        """``op`` of ``args``.

        Raises:
          Unsupported: there is no such operation.
        """
        if op == "convert":
            return self._converted(args[0], dtype)
        if op == "select":
            which, no, yes = args
            return self._selected(which, no, yes, dtype)
        if op == "bitcast":
            return np.asarray(args[0]).view(dtype)[()] if known(args[0]) else self._node(op, args, dtype)
        if op not in OPERATIONS:
            raise Unsupported(op)
        if op.startswith("shift") and not (known(args[1]) and dtype == np.uint32):
            raise Unsupported(f"{op} by what is not constant, or of signed numbers")
        if all(map(known, args)):
            with np.errstate(all="ignore"):
                return dtype.type(OPERATIONS[op](*args))
        simple = self._simplified(op, args, dtype)
        return self._node(op, args, dtype) if simple is None else simple

    def key(self, words: tuple[Entry, Entry], dtype: Any) -> Node:
        """The random key of two uint32 ``words``."""
        if not any(map(known, words)) and words[0].op == words[1].op == "word":
            whole = words[0].args[0]
            if whole is words[1].args[0] and (words[0].args[1], words[1].args[1]) == (0, 1):
                return whole
        return self._node("key", words, dtype)

    def words(self, key: Node) -> tuple[Entry, Entry]:
        """The two words that ``key`` is made of."""
        if key.op == "key":
            return key.args
        kind = np.dtype(np.uint32)
        return self._node("word", (key, np.int32(0)), kind), self._node("word", (key, np.int32(1)), kind)

    def _node(self, op: str, args: tuple[Any, ...], dtype: Any) -> Node:
        if op in _COMMUTE:
            args = tuple(sorted(args, key=_order))
        key = (op, dtype, *map(_key, args))
        if key not in self._made:
            self._made[key] = Node(op, args, dtype, len(self.nodes))
            self.nodes.append(self._made[key])
        return self._made[key]

    def _converted(self, x: Entry, dtype: Any) -> Entry:
        if known(x):
            with np.errstate(all="ignore"):
                return dtype.type(x)
        return x if x.dtype == dtype else self._node("convert", (x,), dtype)

    def _selected(self, which: Entry, no: Entry, yes: Entry, dtype: Any) -> Entry:
        if known(which):
            return yes if which else no
        if no is yes or (known(no) and known(yes) and _key(no) == _key(yes)):
            return no
        if is_key(dtype):
            pairs = zip(self.words(no), self.words(yes), strict=True)
            return self.key(tuple(self.apply("select", (which, *x), x[0].dtype) for x in pairs), dtype)
        return self._node("select", (which, no, yes), dtype)

    def _simplified(self, op: str, args: tuple[Entry, ...], dtype: Any) -> Entry | None:
        """What the operation comes to without being done."""
        if len(args) != 2:
            return None
        a, b = args
        if a is not b and isinstance(a, Node) and isinstance(b, Node):  # most are
            return None
        if op == "add":
            return self._sum(a, b)
        if op == "sub":
            return self._difference(a, b, dtype)
        if op == "mul":
            return self._product(a, b, dtype)
        if op == "div":
            if _is(b, 1):
                return a
            return dtype.type(0) if _is(a, 0) else None
        if op == "pow":
            return self._power(a, b, dtype)
        if op in ("min", "max", "and", "or") and a is b:
            return a
        if op in ("and", "or") and dtype == np.bool_:
            return _logical(a, b, neutral=op == "and")
        if op.startswith("shift") and b >= 32:
            return dtype.type(0)
        return None

    def _sum(self, a: Entry, b: Entry) -> Entry | None:
        return b if _is(a, 0) else a if _is(b, 0) else None

    def _difference(self, a: Entry, b: Entry, dtype: Any) -> Entry | None:
        if a is b:
            return dtype.type(0)
        if _is(b, 0):
            return a
        return self.apply("neg", (b,), dtype) if _is(a, 0) else None

    def _power(self, a: Entry, b: Entry, dtype: Any) -> Entry | None:
        if _is(b, 1):
            return a
        return self.apply("mul", (a, a), dtype) if _is(b, 2) else None

    def _product(self, a: Entry, b: Entry, dtype: Any) -> Entry | None:
        if _is(a, 0) or _is(b, 0):
            return dtype.type(0)
        if _is(a, 1) or _is(b, 1):
            return b if _is(a, 1) else a
        if _is(a, -1) or _is(b, -1):
            return self.apply("neg", (b if _is(a, -1) else a,), dtype)
        return None


def reach(results: list[Entry]) -> list[Node]:
    """The nodes that ``results`` need, in order, without inputs."""
    seen: dict[int, Node] = {}
    open_ = [x for x in results if not known(x)]
    while open_:
        node = open_.pop()
        if node.index in seen or node.op == "input":
            continue
        seen[node.index] = node
        open_ += [x for x in node.args if not known(x)]
    return [seen[i] for i in sorted(seen)]


def _is(entry: Entry, value: int) -> bool:
    return not isinstance(entry, Node) and bool(entry == value)


def is_key(dtype: Any) -> bool:
    """Whether ``dtype`` is that of random keys."""
    return jnp.issubdtype(dtype, jax.dtypes.prng_key)


def _logical(a: Entry, b: Entry, neutral: bool) -> Entry | None:
    """``and`` (``neutral``: True) or ``or`` (False) of two truth values if one is known; else None."""
    for this, other in ((a, b), (b, a)):
        if known(this):
            return other if bool(this) == neutral else this
    return None


def _key(x: Any) -> Any:
    return ("n", x.index) if isinstance(x, Node) else ("c", np.asarray(x).dtype.str, np.asarray(x).tobytes())


def _order(x: Entry) -> tuple[int, int]:
    return (0, x.index) if isinstance(x, Node) else (1, 0)
