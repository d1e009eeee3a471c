"""What the package has made on this machine and may load again: files that nobody else can have written.

They lie beside JAX's programs, or, where these are not kept, for this process alone.
"""

from __future__ import annotations

import contextlib
import fcntl
import functools
import hashlib
import os
import stat
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TypeVar

from jaxwalk.kernels.settings import jax_setting

T = TypeVar("T")
SECONDS = 90
"""How long another process is waited for."""
DAYS = 60
"""A file that nobody has used for so long is dropped when another one is written."""


def kept(name: str, make: Callable[[], bytes], use: Callable[[Path], T]) -> T:
    """What ``use`` makes of the file ``name``, which is made now unless a sound one is there: by one process,
    others wait for that.

    Args:
      make: gives its content. use: of the file; an OSError is of the folder that it lies in, and another is
        tried.

    Raises:
      OSError: no folder will do, the last one's reason.
    """
    content: bytes | None = None
    reason = OSError("there is no folder")
    for folder in _folders():
        file = folder / name
        try:
            if not _sound(file):
                with _alone(file.with_name(f"{name}.lock")):
                    if not _sound(file):
                        content = make() if content is None else content
                        _write(file, content)
            with contextlib.suppress(OSError):  # not of a folder that can only be read
                os.utime(file)
                os.utime(_seal(file))
            return use(file)
        except OSError as error:
            reason = error
    raise reason


def recall(name: str) -> bytes | None:
    """What the file ``name`` holds; None if there is none that can be trusted."""
    for folder in _folders():
        with contextlib.suppress(OSError):
            if _sound(folder / name):
                return (folder / name).read_bytes()
    return None


def _folders() -> Iterator[Path]:
    """Where files may be kept, the best first."""
    cache = jax_setting("jax_compilation_cache_dir")
    if cache and "://" not in cache:
        folder = Path(cache).absolute() / "native"
        with contextlib.suppress(OSError):
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            if _own(folder):
                yield folder
    with contextlib.suppress(OSError):
        yield Path(_temporary().name)


@functools.cache
def _temporary() -> tempfile.TemporaryDirectory[str]:
    """A folder that goes with the process."""
    return tempfile.TemporaryDirectory(prefix="jaxwalk-")


@contextlib.contextmanager
def _alone(file: Path) -> Iterator[None]:
    """One process at a time; the lock of one that has died is nobody's.

    Raises:
      OSError: another holds it for `SECONDS`, having been suspended, perhaps; or it is no plain file.
    """
    until = time.monotonic() + SECONDS
    lock = os.open(file, os.O_RDWR | os.O_CREAT | os.O_NONBLOCK | os.O_NOFOLLOW | os.O_CLOEXEC, 0o600)
    try:
        if not stat.S_ISREG(os.fstat(lock).st_mode):
            raise OSError(f"{file} is no plain file")
        while True:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                break
            except BlockingIOError:
                if time.monotonic() > until:
                    raise OSError(f"another process holds {file}") from None
                time.sleep(0.05)
        yield
    finally:
        os.close(lock)


def _own(path: Path) -> bool:
    """Whether nobody else can have written it."""
    found = path.lstat()
    real = stat.S_ISDIR(found.st_mode) or stat.S_ISREG(found.st_mode)
    return real and found.st_uid == os.geteuid() and not found.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


def _seal(file: Path) -> Path:
    return file.with_name(f"{file.name}.sha256")


def _sound(file: Path) -> bool:
    """Whether it was written whole, by this user."""
    seal = _seal(file)
    try:
        return _own(file) and _own(seal) and seal.read_text() == _digest(file.read_bytes())
    except (OSError, ValueError):
        return False


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _write(file: Path, content: bytes) -> None:
    """Whole or not at all: without its seal, which comes last, a file counts as not there."""
    _tidy(file.parent)
    _seal(file).unlink(missing_ok=True)
    for path, part in ((file, content), (_seal(file), _digest(content).encode())):
        beside = path.with_name(f"{path.name}.new")
        try:
            beside.write_bytes(part)
            beside.chmod(0o600)
            beside.replace(path)
        except OSError:
            beside.unlink(missing_ok=True)
            raise


def _tidy(folder: Path) -> None:
    """Drop what nobody has used for long, and what a process left that was killed."""
    for path in folder.iterdir():
        with contextlib.suppress(OSError):
            age = time.time() - path.stat().st_mtime
            if path.suffix == ".new" or (
                age > DAYS * 86400 and path.suffix != ".sha256" and path.name != "lock"
            ):
                path.unlink()
                _seal(path).unlink(missing_ok=True)
