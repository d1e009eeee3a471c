"""``python files.py COUNT [KIND ...]``: changes each kind of file that often, and sees what comes of it.

Any file ends in success or in one clear line that names it. A program of its own, since the tests' own checks
of signatures would stop what a user's process goes on with.
"""

from __future__ import annotations

import sys
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path

import kinds
from hypothesis import HealthCheck, Phase, given, settings

from jaxwalk.common.errors import UserError


def said(read: Callable[[], object], path: Path) -> str | None:
    """The line that ``read`` ends in, if it does."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # of numbers that no walker has
            read()
        return None
    except UserError as error:
        line = str(error)
        assert str(path) in line or str(path.parent) in line, line
        assert line.isprintable() and len(line) < 1500, line
        return line


def fuzz(kind: kinds.Kind, examples: int) -> None:
    refused: list[str] = []
    count = 0

    # The same examples each time, of which nothing is kept.
    @settings(
        max_examples=examples,
        derandomize=True,
        database=None,
        deadline=None,
        phases=(Phase.generate, Phase.shrink),
        suppress_health_check=list(HealthCheck),  # pyright: ignore[reportArgumentType]  # as hypothesis says
    )
    @given(kind.changes)
    def one(content: bytes) -> None:
        nonlocal count
        count += 1
        kind.path.write_bytes(content)
        line = said(kind.read, kind.path)
        if line is not None:
            refused.append(line)

    whole = kind.path.read_bytes() if kind.path.exists() else None
    try:
        one()
    finally:
        kind.path.unlink(missing_ok=True)
        if whole is not None:
            kind.path.write_bytes(whole)
    assert count >= examples / 2 and len(refused) > count / 5  # or the changes change nothing


def main(argv: list[str]) -> None:
    count, names = int(argv[0]), argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        for name, kind in kinds.make(Path(folder)).items():
            if not names or name in names:
                print(name, flush=True)  # a failure is of the last one
                # Results are large, and there are eight kinds of them.
                fuzz(kind, count // 8 if name.startswith("results") else count)


if __name__ == "__main__":
    main(sys.argv[1:])
