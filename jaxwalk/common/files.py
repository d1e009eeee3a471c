"""Writing results: JSON that any reader accepts, and never half a file."""

from __future__ import annotations

import csv
import io
import json
import math
import os
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
    """Replace ``path`` by ``content``, all at once: a reader sees the old file or the new.

    Raises:
      UserError: the folder is missing, full or closed to us.
    """
    try:
        descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=".jaxwalk.")
        try:
            with os.fdopen(descriptor, "wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            os.chmod(name, 0o666 & ~_umask())  # mkstemp's files are its owner's alone
            os.replace(name, path)
        except BaseException:
            os.unlink(name)
            raise
    except OSError as error:
        raise UserError(
            f"cannot write {path}: {error.strerror}; name a file in a folder that can be written"
        ) from error


def to_csv(lines: Sequence[Mapping[str, Any]]) -> bytes:
    """A table with a head, from lines of the same names."""
    text = io.StringIO()
    writer = csv.DictWriter(text, fieldnames=list(lines[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(lines)
    return text.getvalue().encode()


def check_output(option: str, path: Path) -> None:
    """See, before minutes of work, that a result can be written to ``path``.

    Raises:
      UserError: naming ``option``, when it cannot.
    """
    if os.path.isdir(path):
        raise UserError(f"{option} {path}: is a folder; name a file")
    if not os.path.isdir(path.parent):
        raise UserError(f"{option} {path}: there is no folder {path.parent}; name a file in one that exists")
    most = os.pathconf(path.parent, "PC_NAME_MAX")
    if len(os.fsencode(path.name)) > most:
        raise UserError(f"{option} {path}: its name is too long; give at most {most} bytes")
    if not os.access(path if os.path.exists(path) else path.parent, os.W_OK):
        raise UserError(f"{option} {path}: not writable; name a file in a folder that can be written")


def check_folder(option: str, path: Path) -> None:
    """See, before minutes of work, that results can be put into the folder ``path``, which need not exist.

    Raises:
      UserError: naming ``option``, when they cannot.
    """
    nearest = next(p for p in (path, *path.absolute().parents) if os.path.lexists(p))
    if not os.path.isdir(nearest):
        raise UserError(f"{option} {path}: {nearest} is not a folder; name a folder for the results")
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise UserError(f"{option} {path}: {nearest} is closed to us; name a folder that can be written")


def make_folder(option: str, path: Path) -> None:
    """Make the folder ``path`` with its parents; it may exist.

    Raises:
      UserError: naming ``option``, when it cannot be made.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(f"{option} {path}: {error.strerror}; name a folder that can be written") from error


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
