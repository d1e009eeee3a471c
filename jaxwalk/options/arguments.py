"""Arguments of functions that programs call: looked at as options are, and named as what they are."""

from __future__ import annotations

import functools
import inspect
import numbers
import re
import types
import typing
from collections.abc import Callable, Iterable, Sequence
from os import PathLike
from typing import Any, Literal, TypeVar

from jaxwalk.common import runtime
from jaxwalk.common.errors import UserError

F = TypeVar("F", bound=Callable[..., Any])
_OPTION = re.compile(r"(?<![\w-])--([a-z][\w.-]*)")
_NUMBERS = {int: numbers.Integral, float: numbers.Real}  # NumPy's are such, too


def looked_at(function: F) -> F:
    """``function``, its arguments of the types that it says, under commands' settings of JAX.

    Its errors name arguments, where commands', which share the checks, name options.
    """
    hints, signature = typing.get_type_hints(function), inspect.signature(function)

    @functools.wraps(function)
    def call(*args: Any, **named: Any) -> Any:
        try:
            for name, value in signature.bind(*args, **named).arguments.items():
                check(name, hints[name], value)
            with runtime.as_ours():
                return function(*args, **named)
        except UserError as error:
            raise UserError(_OPTION.sub(lambda found: found[1].replace("-", "_"), str(error))) from error

    return typing.cast(F, call)


def check_fields(value: Any) -> None:
    """See that a dataclass holds what its fields' types say.

    Raises:
      UserError: naming the field.
    """
    for name, kind in typing.get_type_hints(type(value)).items():
        check(name, kind, getattr(value, name))


def check(name: str, kind: Any, value: Any) -> None:
    """See that ``value`` is of the type ``kind``.

    Raises:
      UserError: it is not.
    """
    if not _is(kind, value):
        raise UserError(f"{name} {value!r:.60}: give {_told(kind)}")


def _is(kind: Any, value: Any) -> bool:
    origin, parts = typing.get_origin(kind), typing.get_args(kind)
    if origin in (typing.Union, types.UnionType):
        return any(_is(part, value) for part in parts)
    if origin is Literal:
        return isinstance(value, str) and value in parts
    if origin in (Sequence, tuple):
        many = isinstance(value, Iterable) and not isinstance(value, str | bytes)
        return (many if origin is Sequence else isinstance(value, tuple)) and all(
            _is(parts[0], one) for one in value
        )
    if kind in _NUMBERS:
        return isinstance(value, _NUMBERS[kind]) and not isinstance(value, bool)
    if kind is str or origin is PathLike:
        return isinstance(value, str if kind is str else PathLike) and "\0" not in str(value)
    return isinstance(value, kind)


def _told(kind: Any) -> str:
    """``kind`` in words."""
    origin, parts = typing.get_origin(kind), typing.get_args(kind)
    if origin in (typing.Union, types.UnionType):
        return " or ".join(dict.fromkeys(map(_told, parts)))
    if origin is Literal:
        return f"one of {', '.join(map(str, parts))}"
    if origin in (Sequence, tuple):
        return f"a {'tuple' if origin is tuple else 'sequence'} of which each is {_told(parts[0])}"
    if kind is type(None):
        return "None"
    if kind is str or origin is PathLike:
        return "a text" if kind is str else "a path"
    return {int: "a whole number", float: "a number"}.get(kind, f"a jaxwalk.{kind.__name__}")
