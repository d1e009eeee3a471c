"""The folder of JAX's compiled programs, which commands switch on: looked after, as JAX does not."""

from __future__ import annotations

import contextlib
import glob
import os
import re
import sys
import warnings
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

_SAID = re.compile(
    r"Error (reading|writing) persistent compilation cache entry for '([^']+)': (.*)", re.DOTALL
)


def folder() -> str:
    """Where compiled programs are kept, by JAX's own variable or beside other caches; "": nowhere."""
    if own := os.environ.get("JAX_COMPILATION_CACHE_DIR"):
        return own
    home = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    return os.path.join(home, "jaxwalk") if os.path.isabs(home) else ""  # some users have no home


def guard(kept: str) -> None:
    """Have entries in ``kept`` that were cut short (by a kill, a full disk) removed, where JAX would stumble
    over them in each run anew; and say once, not of each program, that a folder takes none.

    JAX tells of both by warnings alone.
    """
    if isinstance(warnings.showwarning, partial):
        return
    warnings.showwarning = partial(_shown, kept, warnings.showwarning)


def _shown(kept: str, show: Callable[..., None], message: Any, *more: Any, **others: Any) -> None:
    said = _SAID.match(str(message))
    if said is None:
        show(message, *more, **others)
        return
    what, program, why = said.groups()
    # An entry is named by its program and a digest, which the warning does not tell.
    for entry in Path(kept).glob(f"{glob.escape(program)}-*"):
        with contextlib.suppress(OSError):
            entry.unlink()
    if what == "writing":
        _say_once(f"jaxwalk: not all compiled programs are kept in {kept}", why)


_said: set[str] = set()


def _say_once(what: str, why: str) -> None:
    if what not in _said:
        _said.add(what)
        print(f"{what}: {why}", file=sys.stderr, flush=True)
