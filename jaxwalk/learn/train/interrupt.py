"""How a person, or the system, ends a run that would go on."""

from __future__ import annotations

import contextlib
import signal
import sys
import threading
from typing import Any


class Stop:
    """Turns the first Ctrl-C or SIGTERM into a wish; the second interrupts as usual."""

    def __enter__(self) -> Stop:
        self.wanted = False
        self._old = {}
        if threading.current_thread() is threading.main_thread():  # no other may
            self._old = {s: signal.signal(s, self._wish) for s in (signal.SIGINT, signal.SIGTERM)}
        return self

    def _wish(self, number: int, frame: Any) -> None:
        self.wanted = True
        for which, old in self._old.items():
            signal.signal(which, old)
        with contextlib.suppress(OSError, RuntimeError):  # closed, or amid another print
            print(
                "stopping after the report under way; Ctrl-C again ends at once", file=sys.stderr, flush=True
            )

    def __exit__(self, *_: object) -> None:
        for which, old in self._old.items():
            signal.signal(which, old)
