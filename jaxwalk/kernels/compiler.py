"""Shared libraries made by the system's C++ compiler, kept from run to run.

A library is found again by a hash of all that it was made from and for: another compiler, processor, or
version of JAX finds none, and makes its own.
"""

from __future__ import annotations

import contextlib
import ctypes
import fcntl
import functools
import hashlib
import os
import platform
import shutil
import stat
import subprocess
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import jax
import jaxlib

FLAGS = (
    "-std=c++17", "-O2", "-fPIC", "-fvisibility=hidden", "-fno-math-errno", "-fno-trapping-math",
    "-ffp-contract=fast", "-fno-exceptions", "-fno-rtti", "-w",
)  # fmt: skip
SECONDS = 60
"""More than a compiler may take."""


class BuildError(RuntimeError):
    """No library could be made here; the text tells why, and what would help, in one line."""


@functools.cache
def compiler() -> tuple[str, ...]:
    """The command of the system's C++ compiler: ``CXX``, or the first of c++, g++ and clang++.

    Raises:
      BuildError: there is none.
    """
    told = os.environ.get("CXX", "").split()
    found = (
        shutil.which(told[0])
        if told
        else next(filter(None, map(shutil.which, ("c++", "g++", "clang++"))), None)
    )
    if found is None:
        what = f"CXX names {told[0]}, which is not there" if told else "there is no C++ compiler"
        raise BuildError(f"{what}; install g++ (on Debian: apt-get install g++)")
    return (found, *told[1:])


@functools.cache
def _target() -> tuple[str, ...]:
    """The flag that makes a compiler use all that this processor has."""
    return ("-mcpu=native",) if platform.machine() in ("arm64", "aarch64") else ("-march=native",)


@functools.cache
def _made_for() -> str:
    """Compiler, processor and JAX, as text."""
    try:
        version = subprocess.run(
            [*compiler(), "--version"], capture_output=True, text=True, timeout=SECONDS, check=True
        ).stdout
    except (OSError, subprocess.SubprocessError) as error:
        raise BuildError(
            f"{compiler()[0]} does not run ({_line(error)}); install g++ or name another by CXX"
        ) from None
    features = ""
    with contextlib.suppress(OSError):
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        features = next((x for x in lines if x.startswith(("flags", "Features"))), "") + next(
            (x for x in lines if x.startswith("model name")), ""
        )
    return "\n".join([version, platform.machine(), platform.processor(), features, jaxlib.__version__])


def library(sources: tuple[str, ...], flags: tuple[str, ...] = ()) -> ctypes.CDLL:
    """What ``sources`` compile to together, made now or found.

    Args:
      flags: beyond `FLAGS`.

    Raises:
      BuildError: it cannot be made, or not be loaded.
    """
    whole = (*FLAGS, *_target(), *flags)
    name = hashlib.sha256("\0".join((*sources, *compiler(), *whole, _made_for())).encode()).hexdigest()[:32]
    for folder in _folders():
        try:
            with _alone(folder / f"{name}.lock"):
                file = folder / f"{name}.so"
                if not _sound(file):
                    _make(sources, whole, file)
                return ctypes.CDLL(str(file))
        except OSError:
            continue  # it cannot be written, or what lies there not be loaded
    raise BuildError("neither the cache nor a temporary folder can hold a library; make room or set TMPDIR")


def recall(name: str) -> str | None:
    """The text that was kept under ``name``; None if there is none that can be trusted."""
    for folder in _folders():
        file = folder / f"{name}.json"
        with contextlib.suppress(OSError, ValueError):
            seal, _, rest = file.read_text().partition("\n")
            if _own(file) and hashlib.sha256(rest.encode()).hexdigest() == seal:
                return rest
    return None


def keep(name: str, text: str) -> None:
    """Keeps ``text`` for `recall`, whole or, where there is no room, not at all."""
    for folder in _folders():
        with contextlib.suppress(OSError), tempfile.NamedTemporaryFile("w", dir=folder, delete=False) as file:
            try:
                file.write(f"{hashlib.sha256(text.encode()).hexdigest()}\n{text}")
                file.close()
                os.replace(file.name, folder / f"{name}.json")
            except OSError:
                os.unlink(file.name)
                continue
            return


def _folders() -> Iterator[Path]:
    """Where libraries may be kept: beside JAX's programs; else for this process alone."""
    kept = jax.config.jax_compilation_cache_dir
    if kept:
        folder = Path(kept) / "native"
        with contextlib.suppress(OSError):
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            if _own(folder):
                yield folder
    with contextlib.suppress(OSError):
        yield _temporary()


@functools.cache
def _temporary() -> Path:
    keeper = tempfile.TemporaryDirectory(prefix="jaxwalk-")
    _keepers.append(keeper)
    return Path(keeper.name)


_keepers: list[tempfile.TemporaryDirectory] = []


@contextlib.contextmanager
def _alone(file: Path) -> Iterator[None]:
    """One process at a time: a second finds what the first has made."""
    with open(file, "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def _own(path: Path) -> bool:
    """Whether nobody else can have written it."""
    found = path.stat()
    return found.st_uid == os.geteuid() and not found.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


def _sound(file: Path) -> bool:
    """Whether it is a library that was written whole, by this user."""
    seal = file.with_suffix(".sha256")
    try:
        return _own(file) and _own(seal) and seal.read_text() == _digest(file)
    except OSError:
        return False


def _digest(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()


def _make(sources: tuple[str, ...], flags: tuple[str, ...], file: Path) -> None:
    with tempfile.TemporaryDirectory(dir=file.parent) as name, ThreadPoolExecutor(os.cpu_count()) as threads:
        folder, until = Path(name), time.monotonic() + SECONDS

        def object_of(numbered: tuple[int, str]) -> str:
            number, source = numbered
            file = folder / f"{number}.cc"
            file.write_text(source)
            made = str(file.with_suffix(".o"))
            _run([*flags, f"-I{jax.ffi.include_dir()}", "-c", str(file), "-o", made], until)
            return made

        made, seal = folder / "walk.so", folder / "walk.sha256"
        _run([*flags, "-shared", *threads.map(object_of, enumerate(sources)), "-o", str(made), "-lm"], until)
        seal.write_text(_digest(made))
        for part in (made, seal):
            part.chmod(0o600)
        # The seal last: without it the library counts as not there.
        file.with_suffix(".sha256").unlink(missing_ok=True)
        made.replace(file)
        seal.replace(file.with_suffix(".sha256"))


def _run(arguments: list[str], until: float) -> None:
    """The compiler, to be done at ``until``, as `time.monotonic` counts.

    Raises:
      BuildError: it fails, or is not.
    """
    name = compiler()[0]
    try:
        done = subprocess.run(
            [*compiler(), *arguments],
            capture_output=True,
            text=True,
            timeout=max(0.1, until - time.monotonic()),
        )
    except subprocess.TimeoutExpired:
        raise BuildError(
            f"{name} took more than {SECONDS} s; install another (g++) or name it by CXX"
        ) from None
    except OSError as error:
        raise BuildError(
            f"{name} does not run ({_line(error)}); install g++ or name another by CXX"
        ) from None
    if done.returncode:
        raise BuildError(
            f"{name} failed ({_line(done.stderr) or done.returncode}); install g++ or name another by CXX"
        )


def _line(what: object) -> str:
    """The first line that tells an error, shortened."""
    lines = str(what).splitlines() or [""]
    return next((x for x in lines if "error" in x.lower()), lines[0])[:200]
