"""What is searched: options of ``jaxwalk train`` with a range or a few values each."""

from __future__ import annotations

import dataclasses
import difflib
import math
import re
import types
import typing
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from jaxwalk.common.errors import UserError
from jaxwalk.config import Config, of_dict, to_dict, validate


@dataclass(frozen=True)
class Range:
    """A number between two others.

    Attributes:
      name: of the field, dotted. low, high: both can be drawn.
      log: evenly in the logarithm. whole: whole numbers only.
    """

    name: str
    low: float | int
    high: float | int
    log: bool
    whole: bool


@dataclass(frozen=True)
class Choice:
    """One of some values.

    Attributes:
      name: of the field, dotted.
      texts: the values as they are given; distinct.
    """

    name: str
    texts: tuple[str, ...]


Dimension = Range | Choice


def parse(texts: Sequence[str], config: Config) -> tuple[Dimension, ...]:
    """The space of ``--set OPTION=LOW:HIGH[:log]`` and ``--set OPTION=VALUE,VALUE`` (``|`` for lists).

    Args:
      config: has the values of all other options.

    Raises:
      UserError: no option, one twice, one that there is not, or values that it cannot have.
    """
    if not texts:
        raise UserError("--set: give one or more options to search, as ddpg.gamma=0.7:0.95")
    space = tuple(_dimension(text) for text in texts)
    names = [one.name for one in space]
    for text, name in zip(texts, names, strict=True):
        if names.count(name) > 1:
            raise UserError(f"--set {text}: give each option once")
    for text, one in zip(texts, space, strict=True):
        for value in [one.low, one.high] if isinstance(one, Range) else one.texts:
            try:
                validate.check(changed(config, {one.name: value}))
            except UserError as error:
                raise UserError(f"--set {text}: {error}") from None
    return space


def changed(config: Config, values: Mapping[str, float | int | str]) -> Config:
    """``config`` with other values of some fields; texts are read as the field's type.

    Raises:
      UserError: a value of another type.
    """
    tree = to_dict(config)
    kinds = _kinds(Config)
    for name, value in values.items():
        *path, last = name.split(".")
        part = tree
        for step in path:
            part = part[step]
        part[last] = _value(kinds[name], value) if isinstance(value, str) else value
    return of_dict(tree)


def without_password(text: str) -> str:
    """``text``, less the passwords of the URLs in it: behind the user, or as an argument."""
    hidden = re.sub(r"(://[^:/@\s]*:)[^@\s]*@", r"\1***@", text)
    return re.sub(r"([?&]password=)[^&\s]*", r"\1***", hidden)


def to_json(space: Sequence[Dimension]) -> list[dict[str, Any]]:
    """Plain values that are equal where spaces are."""
    return [
        {name: list(x) if isinstance(x, tuple) else x for name, x in dataclasses.asdict(one).items()}
        for one in sorted(space, key=lambda one: one.name)
    ]


def _dimension(text: str) -> Dimension:
    option, equals, given = text.partition("=")
    name, kinds = option.strip().removeprefix("--").replace("-", "_"), _kinds(Config)
    if not equals or not given.strip():
        raise UserError(f"--set {text}: give OPTION=LOW:HIGH, OPTION=LOW:HIGH:log or OPTION=VALUE,VALUE")
    if name not in kinds:
        close = difflib.get_close_matches(name, kinds, n=2)
        meant = f", perhaps {' or '.join(one.replace('_', '-') for one in close)}" if close else ""
        raise UserError(f"--set {text}: jaxwalk train has no option {option.strip()}{meant}")
    kind = kinds[name]
    if ":" in given and kind in (int, float):
        return _range(text, name, kind, given.split(":"))
    separator = "|" if "|" in given or typing.get_origin(kind) is tuple else ","
    texts = tuple(" ".join(one.split()) for one in given.split(separator))
    if not all(texts) or len(set(texts)) < len(texts):
        raise UserError(f"--set {text}: give two values or more, each once, without gaps")
    if len(texts) < 2:
        raise UserError(
            f"--set {text}: give two values or more, or set the option itself, --{option.strip()}"
        )
    return Choice(name, texts)


def _range(text: str, name: str, kind: type, parts: Sequence[str]) -> Range:
    what = "whole numbers" if kind is int else "numbers"
    if len(parts) not in (2, 3) or parts[2:] not in ([], ["log"]):
        raise UserError(f"--set {text}: give LOW:HIGH or LOW:HIGH:log")
    try:
        low, high = (kind(part) for part in parts[:2])
    except ValueError:
        raise UserError(f"--set {text}: give {what} for LOW and HIGH") from None
    log = len(parts) == 3
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise UserError(f"--set {text}: LOW must be below HIGH")
    if log and low <= 0:
        raise UserError(f"--set {text}: a logarithmic range must begin above 0")
    return Range(name, low, high, log, kind is int)


def _kinds(cls: Any, where: str = "") -> dict[str, Any]:
    """The type of every field, by its dotted name."""
    found: dict[str, Any] = {}
    for name, kind in typing.get_type_hints(cls).items():
        path = f"{where}.{name}" if where else name
        found |= _kinds(kind, path) if dataclasses.is_dataclass(kind) else {path: kind}
    return found


def _value(kind: Any, text: str) -> Any:
    """The JSON value that ``text`` means to a field; one that makes no sense stays, and is refused there."""
    origin, args = typing.get_origin(kind), typing.get_args(kind)
    if origin is tuple:
        return [_value(args[0], item) for item in text.split()]
    if origin in (typing.Union, types.UnionType):
        if text == "None":
            return None
        (kind,) = (arg for arg in args if arg is not type(None))
    if kind is bool or origin is Literal:
        return {"True": True, "False": False}.get(text, text)
    try:
        return kind(text) if kind in (int, float) else text
    except ValueError:
        return text
