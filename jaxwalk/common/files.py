"""Writing results: JSON that any reader accepts, and never half a file."""

from __future__ import annotations

import contextlib
import csv
import io
import json
import math
import os
import stat
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from jaxwalk.common.errors import UserError


def to_json(value: Any, indent: int | None = None) -> str:
    """JSON text. Scalars of NumPy and JAX become numbers, their arrays lists, NaN and infinity null."""
    return json.dumps(_plain(value), indent=indent, allow_nan=False)


def write_json(path: Path, value: Any) -> None:
    """Replace ``path`` by ``value`` as JSON, all at once.

    Raises:
      UserError: the folder is missing, full or closed to us.
    """
    write_bytes(path, json_file(value))


def json_file(value: Any) -> bytes:
    """``value`` as a JSON file's content."""
    return (to_json(value, indent=2) + "\n").encode()


def write_bytes(path: Path, content: bytes) -> None:
    """As `replace`, for whoever writes results.

    Raises:
      UserError: the folder is missing, full or closed to us.
    """
    try:
        replace(path, content)
    except OSError as error:
        raise UserError(
            f"cannot write {path}: {error.strerror}; name a file in a folder that can be written"
        ) from error


def replace(path: Path, content: bytes) -> None:
    """Replace ``path`` by ``content``, all at once: a reader sees the old file or the new.

    What a link leads to is replaced, not the link. What is no ordinary file (a device, a pipe), and the file
    that standard output goes to, is written to and stays what it is.

    Raises:
      OSError: the folder is missing, full or closed to us.
    """
    if is_stream(path):
        with contextlib.suppress(AttributeError, ValueError):  # none, or a closed one
            sys.stdout.flush()
        with open(os.open(path, os.O_WRONLY | os.O_APPEND), "wb") as stream:
            stream.write(content)
        return
    real = os.path.realpath(path)
    descriptor, name = tempfile.mkstemp(dir=os.path.dirname(real), prefix=".jaxwalk.")
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(name, 0o666 & ~_umask())  # mkstemp's files are its owner's alone
        os.replace(name, real)
    except BaseException:
        os.unlink(name)
        raise


def is_stream(path: Path) -> bool:
    """Whether ``path`` is written to as it is, see `replace`."""
    try:
        found = os.stat(path)
    except (OSError, ValueError):  # ValueError: a path that no system takes
        return False
    if not stat.S_ISREG(found.st_mode):
        return not stat.S_ISDIR(found.st_mode)
    for descriptor in (1, 2):
        with contextlib.suppress(OSError):
            if os.path.samestat(found, os.fstat(descriptor)):
                return True
    return False


def drop_stump(log: Path) -> None:
    """Cut off what is no whole line at the end of ``log``: who appends would glue the next record to it.

    Raises:
      OSError: it cannot be written.
    """
    with open(log, "rb+") as file:
        end = file.seek(0, os.SEEK_END)
        while end > 0:
            start = max(0, end - 2**16)
            file.seek(start)
            if found := file.read(end - start).rfind(b"\n") + 1:
                end = start + found
                break
            end = start
        if end < file.seek(0, os.SEEK_END):
            file.truncate(end)


def to_csv(lines: Sequence[Mapping[str, Any]]) -> bytes:
    """A table with a head, from lines of the same names. No text of a user's is a spreadsheet's formula."""
    text = io.StringIO()
    writer = csv.DictWriter(text, fieldnames=list(lines[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows({name: _inert(value) for name, value in line.items()} for line in lines)
    return text.getvalue().encode()


def check_output(option: str, path: Path) -> None:
    """See, before minutes of work, that a result can be written to ``path``, and change nothing.

    Raises:
      UserError: naming ``option``, when it cannot.
    """
    folder = (Path(os.path.realpath(path)) if os.path.islink(path) else path).parent
    if os.path.isdir(path):
        raise UserError(f"{option} {path}: is a folder; name a file")
    if is_stream(path):
        if not (os.path.isfile(path) or stat.S_ISCHR(mode := os.stat(path).st_mode) or stat.S_ISFIFO(mode)):
            raise UserError(f"{option} {path}: is a socket or a disk; name a file, a pipe or a terminal")
        problem = None if os.access(path, os.W_OK) else "not writable"
    elif not os.path.isdir(folder):
        raise UserError(f"{option} {path}: there is no folder {folder}; name a file in one that exists")
    elif len(os.fsencode(path.name)) > (most := os.pathconf(folder, "PC_NAME_MAX")):
        raise UserError(f"{option} {path}: its name is too long; give at most {most} bytes")
    elif os.path.exists(path) and not os.access(path, os.W_OK):
        problem = "not writable"
    else:
        problem = _closed(folder)
    if problem:
        raise UserError(f"{option} {path}: {problem}; name a file in a folder that can be written")


def check_folder(option: str, path: Path) -> None:
    """See, before minutes of work, that results can be put into the folder ``path``, which need not exist.

    Raises:
      UserError: naming ``option``, when they cannot.
    """
    if problem := unusable(path):
        raise UserError(f"{option} {path}: {problem}; name a folder for the results that can be written")


def unusable(path: Path) -> str | None:
    """Why nothing can be put into the folder ``path``, which need not exist; None: it can."""
    nearest = next(p for p in (path, *path.absolute().parents) if os.path.lexists(p))
    if not os.path.isdir(nearest):
        return f"{nearest} is not a folder"
    problem = _closed(nearest)
    return problem and f"{nearest} is closed to us ({problem})"


def _closed(folder: Path) -> str | None:
    """What the system says to a new file in ``folder``; None: nothing. Rights alone do not tell."""
    try:
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        return error.strerror or str(error)
    return None


def make_folder(option: str, path: Path) -> None:
    """Make the folder ``path`` with its parents; it may exist.

    Raises:
      UserError: naming ``option``, when it cannot be made.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(f"{option} {path}: {error.strerror}; name a folder that can be written") from error


def _inert(value: Any) -> Any:
    return f"'{value}" if isinstance(value, str) and value.startswith(("=", "+", "-", "@")) else value


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
