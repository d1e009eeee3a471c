"""Reading files that anybody may have written: no memory before their size is known, no fault but one line.

JSON is UTF-8 and strict: no NaN, no name twice, no number beyond what 64 bits hold, not nested without end.
"""

from __future__ import annotations

import json
import math
import os
import stat
from collections import Counter
from typing import Any, NoReturn

from jaxwalk.common.errors import UserError

MAX_JSON = 16 * 2**20  # bytes; the largest result that is kept, a comparison, has a fifth of a megabyte
MAX_DEPTH = 64


class Bad(Exception):
    """What is wrong with a file's content, in words for a message."""


def content(path: str | os.PathLike[str], most: int, cure: str) -> bytes:
    """All bytes of an ordinary file.

    Args:
      most: bytes that it may have.
      cure: what would be right, the end of the message.

    Raises:
      UserError: no such file, something else than a file, one that is closed to us, or too large.
    """
    try:
        # A pipe without a writer would keep the opener waiting.
        with open(path, "rb", opener=lambda name, flags: os.open(name, flags | os.O_NONBLOCK)) as file:
            told = os.fstat(file.fileno())
            if not stat.S_ISREG(told.st_mode):
                raise Bad("not an ordinary file")
            if told.st_size > most:
                raise Bad(f"{told.st_size} bytes, more than the {most} that it may have")
            found = file.read(told.st_size + 1)
            if len(found) != told.st_size:
                raise Bad("it changed while it was read")
            return found
    except OSError as error:
        raise UserError(unreadable(path, error.strerror or str(error), cure)) from None
    except (Bad, ValueError) as error:  # ValueError: a path that no system takes
        raise UserError(unreadable(path, str(error), cure)) from None


def unreadable(path: str | os.PathLike[str], why: object, cure: str) -> str:
    """The message for a file that is not what it should be."""
    return f"cannot read {os.fspath(path)}: {why}; {cure}"


def read_json(path: str | os.PathLike[str], cure: str, most: int = MAX_JSON) -> Any:
    """The value in a JSON file.

    Raises:
      UserError: as for `content`, or it is not JSON as this module wants it.
    """
    try:
        return parse(content(path, most, cure))
    except Bad as bad:
        raise UserError(unreadable(path, bad, cure)) from None


def parse(text: str | bytes) -> Any:
    """The value of JSON text, whose length the caller has bounded.

    Raises:
      Bad: it is not JSON as this module wants it.
    """
    try:
        value = json.loads(
            text.decode() if isinstance(text, bytes) else text,
            object_pairs_hook=_object,
            parse_constant=_constant,
            parse_float=_float,
            parse_int=_int,
        )
    except UnicodeDecodeError:
        raise Bad("not UTF-8 text") from None
    except RecursionError:
        raise Bad(f"nested more than {MAX_DEPTH} deep") from None
    except ValueError as error:
        raise Bad(f"not JSON ({error})") from None
    _check_depth(value)
    return value


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        twice, _ = Counter(name for name, _ in pairs).most_common(1)[0]
        raise Bad(f"the name {twice!r:.60} is there twice")
    return found


def _constant(text: str) -> NoReturn:
    raise Bad(f"{text} is no number in JSON")


def _float(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise Bad(f"the number {text:.20} is out of range")
    return value


def _int(text: str) -> int:
    # Looked at before it is made a number: that takes long where it has many digits.
    if len(text) > 20 or not -(2**63) <= (value := int(text)) < 2**63:
        raise Bad(f"the number {text:.20} is out of range")
    return value


def _check_depth(value: Any) -> None:
    level = [value]
    for _ in range(MAX_DEPTH):
        below: list[Any] = []
        for one in level:
            if isinstance(one, dict):
                below += one
                below += one.values()
            elif isinstance(one, list):
                below += one
        if not below:
            return
        level = below
    raise Bad(f"nested more than {MAX_DEPTH} deep")
