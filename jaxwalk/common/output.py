"""Standard output that takes nothing more: one line, whoever printed to it."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator
from typing import Any, TextIO, cast

from jaxwalk.common.errors import UserError


class _Output:
    """A stream whose full disk is told as the user's, not taken for that of a file under way."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """As of a file."""
        with _explained():
            return self._stream.write(text)

    def flush(self) -> None:
        """As of a file."""
        with _explained():
            self._stream.flush()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


@contextlib.contextmanager
def told() -> Iterator[None]:
    """Within it, and at its end, a standard output that takes nothing more is one line.

    Raises:
      UserError: it takes nothing more.
      BrokenPipeError: nobody reads it any more.
    """
    if sys.stdout is None:
        yield
        return
    with contextlib.redirect_stdout(cast(TextIO, _Output(sys.stdout))):
        yield
        sys.stdout.flush()


def forget() -> None:
    """The interpreter tries once more at its end: let it write what nobody took to nowhere."""
    for stream in (sys.stdout, sys.stderr):
        if stream is None:
            continue
        try:
            stream.flush()
        except OSError:
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, stream.fileno())
            os.close(nowhere)


@contextlib.contextmanager
def _explained() -> Iterator[None]:
    try:
        yield
    except BrokenPipeError:
        raise
    except OSError as error:
        raise UserError(
            f"cannot write standard output: {error.strerror}; send it to where there is room"
        ) from error
