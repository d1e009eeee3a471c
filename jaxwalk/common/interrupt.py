"""How a person, or the system, ends a run that would go on."""

from __future__ import annotations

import contextlib
import os
import signal
import stat
import sys
import threading
from collections.abc import Iterator
from typing import Any, NoReturn

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_ended_by = 0


class Stop:
    """Turns the first Ctrl-C, SIGTERM or SIGHUP into a wish; the second does as usual.

    A signal that the process was started to ignore, as by nohup, stays ignored.

    Args:
      what: is under way and will be ended, as the user is told.
    """

    def __init__(self, what: str = "report") -> None:
        self._what = what

    def __enter__(self) -> Stop:
        self.wanted = False
        self._old = {}
        if threading.current_thread() is threading.main_thread():  # no other may
            heard = [one for one in _SIGNALS if signal.getsignal(one) is not signal.SIG_IGN]
            self._old = {one: signal.signal(one, self._wish) for one in heard}
        return self

    def _wish(self, number: int, frame: Any) -> None:
        global _ended_by
        self.wanted, _ended_by = True, number
        for which, old in self._old.items():
            signal.signal(which, old)
        if number == signal.SIGHUP:
            _leave_terminal()
        with contextlib.suppress(OSError, RuntimeError):  # closed, or amid another print
            print(
                f"stopping after the {self._what} under way; Ctrl-C again ends at once",
                file=sys.stderr,
                flush=True,
            )

    def __exit__(self, *_: object) -> None:
        for which, old in self._old.items():
            signal.signal(which, old)


@contextlib.contextmanager
def listening() -> Iterator[None]:
    """Within it Ctrl-C interrupts, where it has ended the process at once so far, and is not forgotten.

    An interrupt can be lost: what is raised while an object is taken down goes nowhere.
    """
    old = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or old is signal.SIG_IGN:
        yield
        return
    signal.signal(signal.SIGINT, _interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, old)


def _interrupt(number: int, frame: Any) -> NoReturn:
    global _ended_by
    _ended_by = number
    raise KeyboardInterrupt


def exit_code(begun: bool = False) -> int:
    """What the process ends with: 128 and the number of the signal that a `Stop` has met, or 0.

    Args:
      begun: forget of any.
    """
    global _ended_by
    if begun:
        _ended_by = 0
    return 128 + _ended_by if _ended_by else 0


def _leave_terminal() -> None:
    """Nothing can be printed to one that was hung up: what is still told goes nowhere."""
    for descriptor in (1, 2):
        with contextlib.suppress(OSError):
            if stat.S_ISCHR(os.fstat(descriptor).st_mode):
                nowhere = os.open(os.devnull, os.O_WRONLY)
                os.dup2(nowhere, descriptor)
                os.close(nowhere)
