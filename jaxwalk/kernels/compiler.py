"""Shared libraries made by the system's C++ compiler, kept from run to run.

A library is found again by a hash of all that it was made from and for: another compiler, processor, or
version of JAX finds none, and makes its own.
"""

from __future__ import annotations

import contextlib
import ctypes
import functools
import hashlib
import os
import platform
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import jax
import jaxlib.version

from jaxwalk.kernels import store

# Overflow wraps, as JAX has it; numbers are moved as bits.
FLAGS = (
    "-std=c++17", "-O2", "-fPIC", "-fvisibility=hidden", "-fwrapv", "-fno-strict-aliasing", "-fno-math-errno",
    "-fno-trapping-math", "-ffp-contract=fast", "-fno-exceptions", "-fno-rtti", "-w",
)  # fmt: skip
SECONDS = 60
"""More than a compiler may take for one file."""
_CURE = "install g++ (on Debian: apt-get install g++) or name a compiler by CXX"


class BuildError(RuntimeError):
    """No library could be made here; the text tells why, and what would help, in one line."""


@functools.cache
def compiler() -> tuple[str, ...]:
    """The command of the system's C++ compiler: ``CXX``, or the first of c++, g++ and clang++.

    Raises:
      BuildError: there is none.
    """
    told = os.environ.get("CXX", "").split()
    found = next(filter(None, map(shutil.which, told[:1] or ("c++", "g++", "clang++"))), None)
    if found is None:
        what = f"CXX names {told[0]:.80}, which is no command" if told else "there is no C++ compiler"
        raise BuildError(f"{what}; {_CURE}")
    return (found, *told[1:])


def compiled(sources: tuple[str, ...], name: str) -> Callable[..., Any]:
    """The function called ``name`` of what ``sources`` compile to together, made now or found.

    Raises:
      BuildError: it cannot be made, kept, or loaded.
    """
    told = "\0".join((*sources, *compiler(), *FLAGS, _made_for()))
    file = f"{hashlib.sha256(told.encode()).hexdigest()[:32]}.so"
    try:
        return store.kept(
            file, lambda: _made(sources, name), lambda path: getattr(ctypes.CDLL(str(path)), name)
        )
    except OSError as error:
        raise BuildError(
            f"a compiled library cannot be kept or loaded ({_line(error)}); make room, or name by TMPDIR a "
            "folder that can be written and executed from"
        ) from None


@functools.cache
def _made_for() -> str:
    """Compiler, processor and JAX, as text."""
    features = ""
    with contextlib.suppress(OSError):
        told = Path("/proc/cpuinfo").read_text(errors="replace").splitlines()
        kinds = ("flags", "Features", "model name", "CPU part")
        features = "\n".join(dict.fromkeys(line for line in told if line.startswith(kinds)))
    version = _run(["--version"])
    jax_version = jaxlib.version.__version__
    return "\n".join([version, platform.machine(), platform.processor(), features, jax_version])


def _made(sources: tuple[str, ...], name: str) -> bytes:
    """The library, by as many compilers at once as there are processors; it has been loaded once."""
    for_this = "-mcpu=native" if platform.machine() in ("arm64", "aarch64") else "-march=native"
    flags = [*FLAGS, for_this, f"-I{jax.ffi.include_dir()}"]
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    try:
        with tempfile.TemporaryDirectory(prefix="jaxwalk-") as folder, ThreadPoolExecutor(count) as threads:

            def object_of(numbered: tuple[int, str]) -> str:
                number, source = numbered
                file = Path(folder) / f"{number}.cc"
                file.write_text(source)
                made = str(file.with_suffix(".o"))
                _run([*flags, "-c", str(file), "-o", made])
                return made

            whole = Path(folder) / "walk.so"
            objects = threads.map(object_of, enumerate(sources))
            _run([*flags, "-shared", *objects, "-o", str(whole), "-lm"])
            _tried(whole, name)
            return whole.read_bytes()
    except OSError as error:
        raise BuildError(
            f"nothing can be compiled in {tempfile.gettempdir()} ({_line(error)}); "
            "name by TMPDIR a folder with room"
        ) from None


def _tried(file: Path, name: str) -> None:
    """See that a library can be loaded and has the function, in a process of its own: it may end that.

    Raises:
      BuildError: it cannot, or has not.
    """
    code = "import ctypes, sys; getattr(ctypes.CDLL(sys.argv[1]), sys.argv[2])"
    told = [sys.executable, "-I", "-c", code, str(file), name]
    done = subprocess.run(told, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace")
    # A folder that forbids execution is not the compiler's fault; where it is kept may be another.
    if done.returncode and "failed to map segment" not in done.stderr:
        why = (done.stderr.strip().splitlines() or [f"signal {-done.returncode}"])[-1][:200]
        raise BuildError(f"what {compiler()[0]} made cannot be loaded ({why}); {_CURE}")


def _run(arguments: list[str]) -> str:
    """What the compiler prints.

    Raises:
      BuildError: it fails, or takes too long; it and all that it has started are ended then.
    """
    name = compiler()[0]
    try:
        process = subprocess.Popen(
            [*compiler(), *arguments],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
            start_new_session=True,
        )
    except OSError as error:
        raise BuildError(f"{name} does not run ({_line(error)}); {_CURE}") from None
    try:
        out, err = process.communicate(timeout=SECONDS)
    except BaseException as error:
        with contextlib.suppress(OSError):
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        if isinstance(error, subprocess.TimeoutExpired):
            raise BuildError(f"{name} took more than {SECONDS} s; {_CURE}") from None
        raise
    if process.returncode:
        raise BuildError(f"{name} failed ({_line(err or out) or f'exit code {process.returncode}'}); {_CURE}")
    return out


def _line(what: object) -> str:
    """The first line that tells an error, shortened."""
    lines = [line.strip() for line in str(what).splitlines() if line.strip()] or [""]
    return next((x for x in lines if "error" in x.lower()), lines[0])[:200]
