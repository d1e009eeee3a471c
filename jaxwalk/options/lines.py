"""Options back into the command line that gives them."""

from __future__ import annotations

import dataclasses
import shlex
import typing
from collections.abc import Sequence
from typing import Any

import tyro
from tyro.constructors import PrimitiveConstructorSpec

from jaxwalk.options.parse import plain


def words(command: str, args: Any) -> list[str]:
    """The arguments after the program's name that `parse` makes ``args`` of.

    What has its default is left out.

    Args:
      args: the options, a dataclass.
    """
    hints = typing.get_type_hints(type(args), include_extras=True)
    given, found = [], [command]
    for field in dataclasses.fields(args):
        value, extras = getattr(args, field.name), getattr(hints[field.name], "__metadata__", ())
        if tyro.conf.Positional in extras:
            given += _texts(value, extras)
        elif isinstance(value, bool) and value != field.default:
            found.append(f"--{'' if value else 'no-'}{field.name.replace('_', '-')}")
        elif value != field.default:
            found += [f"--{field.name.replace('_', '-')}", *_texts(value, extras)]
    return [found[0], *given, *found[1:]]


def line(command: str, args: Any) -> str:
    """``jaxwalk COMMAND ...`` for a shell, see `words`."""
    return shlex.join(["jaxwalk", *words(command, args)])


def _texts(value: Any, extras: Sequence[Any]) -> list[str]:
    """As the option's type writes it, if it has a writing of its own."""
    for extra in extras:
        if isinstance(extra, PrimitiveConstructorSpec):
            return extra.str_from_instance(value)
    return [plain(item) for item in value] if isinstance(value, tuple) else [plain(value)]
