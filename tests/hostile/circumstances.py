"""What a machine may do to a command: each a change of its environment or of its process."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

SECONDS = 300  # after which a command counts as hung


def _nothing() -> None:
    pass


def _limit(which: int, most: int) -> Callable[[], None]:
    return lambda: resource.setrlimit(which, (most, most))


@dataclass(frozen=True)
class Circumstance:
    """What is different.

    Attributes:
      set, drop: variables of the environment.
      before: done in the process before the command.
      code: it ends with; 2: one line says why, and nothing is left behind.
    """

    set: Mapping[str, str] = field(default_factory=dict)
    drop: Sequence[str] = ()
    before: Callable[[], None] = _nothing
    code: int = 0


CIRCUMSTANCES = {
    "a home that takes nothing": Circumstance({"HOME": "/proc/1"}, ["XDG_CACHE_HOME"]),
    "no home": Circumstance(drop=["HOME", "XDG_CACHE_HOME"]),
    "a strange locale": Circumstance({"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}),
    "settings of other programs": Circumstance(
        {
            "JAX_ENABLE_X64": "1", "JAX_DEFAULT_PRNG_IMPL": "rbg", "JAX_NUMPY_RANK_PROMOTION": "raise",
            "MPLBACKEND": "nonsense", "TERM": "dumb", "COLUMNS": "1",
        }
    ),
    "no standard streams": Circumstance(before=lambda: (os.close(0), os.close(1))[0]),
    "little memory": Circumstance(before=_limit(resource.RLIMIT_AS, 4 * 2**30)),
    "a disk that takes no more": Circumstance(before=_limit(resource.RLIMIT_FSIZE, 2**10), code=2),
    "a platform that is not here": Circumstance({"JAX_PLATFORMS": "nonsense"}, code=2),
}  # fmt: skip


def started(argv: Sequence[str], folder: Path, one: Circumstance) -> subprocess.Popen[str]:
    """``jaxwalk argv`` under way in ``folder``."""
    environment = {name: value for name, value in os.environ.items() if name not in one.drop}
    return subprocess.Popen(
        [sys.executable, "-m", "jaxwalk", *argv],
        cwd=folder, env=environment | dict(one.set), preexec_fn=one.before, text=True,
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip


def ended(process: subprocess.Popen[str]) -> tuple[int, str]:
    """Its exit code, and what it said on standard error."""
    try:
        _, error = process.communicate(timeout=SECONDS)
    except subprocess.TimeoutExpired:
        process.kill()
        raise
    return process.returncode, error
