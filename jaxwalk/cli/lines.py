"""Options back into the command line that gives them."""

from __future__ import annotations

import dataclasses
import shlex
import typing
from typing import Any

import tyro


def words(command: str, args: Any) -> list[str]:
    """The arguments after the program's name that `parse` makes ``args`` of.

    What has its default is left out; a list of numbers is written with commas, as it is read.

    Args:
      args: the options, a dataclass.
    """
    hints = typing.get_type_hints(type(args), include_extras=True)
    given, found = [], [command]
    for field in dataclasses.fields(args):
        value = getattr(args, field.name)
        if tyro.conf.Positional in getattr(hints[field.name], "__metadata__", ()):
            given += _texts(value)
        elif value != field.default:
            found += [f"--{field.name.replace('_', '-')}", *_texts(value)]
    return [found[0], *given, *found[1:]]


def line(command: str, args: Any) -> str:
    """``jaxwalk COMMAND ...`` for a shell, see `words`."""
    return shlex.join(["jaxwalk", *words(command, args)])


def _texts(value: Any) -> list[str]:
    if isinstance(value, tuple):
        texts = [_text(item) for item in value]
        return [",".join(texts)] if all(isinstance(item, float) for item in value) else texts
    return [_text(value)]


def _text(value: Any) -> str:
    """A number in the fewest digits that read back as the same."""
    return repr(value).removesuffix(".0") if isinstance(value, float) else str(value)
