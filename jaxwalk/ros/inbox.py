"""The commands of all joints as they come, a topic each, and which tick they are for.

A joint's command carries no time: what comes after a frame has gone out is taken for its answer, which one
controller, a message a joint and frame, makes true. So that none is taken twice or mixed, the first
controller heard is the only one that is.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from jaxwalk.ros import wire
from jaxwalk.ros.watch import OLDEST


class Inbox:
    """Of ``joints`` joints.

    Args:
      say: called with one line where something is amiss.

    Attributes:
      latency: s from the last frame's going out to its last command; NaN where that did not come.
    """

    def __init__(self, joints: int, say: Callable[[str], None]) -> None:
        self._joints, self._say = joints, say
        self._ready = threading.Condition()
        self._said: set[str] = set()
        self._owner = ""
        self.clear()

    def clear(self) -> None:
        """Forget all commands; whose they were, too."""
        with self._ready:
            self._fresh: dict[int, float] = {}
            self._held, self._at = wire.PASSIVE, -OLDEST
            self._lost, self._owner = False, ""
            self.latency = float("nan")
            self._opened, self._now = time.monotonic(), 0

    def open(self, now: int) -> None:
        """A frame of ``now`` (ns) goes out: commands that come are its answers."""
        with self._ready:
            self._fresh = {}
            self.latency = float("nan")
            self._opened, self._now = time.monotonic(), now

    def put(self, joint: int, value: float, sender: str) -> None:
        """A command of ``sender``, a node's name."""
        with self._ready:
            self._owner = self._owner or sender
            if sender != self._owner:
                self._once(f"commands of {sender} are left out: {self._owner} controls the walker")
                return
            self._fresh[joint] = value
            if len(self._fresh) == self._joints:
                self._held, self._at = tuple(self._fresh[row] for row in range(self._joints)), self._now
                self.latency = time.monotonic() - self._opened
                self._lost = False
                self._ready.notify_all()

    def wait(self, patience: float) -> tuple[float, ...]:
        """The answer to the frame that went out; passive joints where none comes within ``patience`` s.

        Who has kept it waiting once is not waited for again until heard.
        """
        with self._ready:
            complete = self._ready.wait_for(
                lambda: len(self._fresh) == self._joints, 0.0 if self._lost else patience
            )
            if complete:
                return self._held
            self._lost, self._owner = True, ""
            self._once(f"no command within {patience:g} s: joints are passive")
            return wire.PASSIVE

    def newest(self, now: int) -> tuple[float, ...]:
        """The newest command; passive joints where it is older than `OLDEST`."""
        with self._ready:
            if now - self._at <= OLDEST:
                return self._held
            self._owner = ""
            if self._at >= 0:
                self._once(f"no command for more than {OLDEST // 1_000_000} ms: joints are passive")
            return wire.PASSIVE

    def _once(self, text: str) -> None:
        if text not in self._said:
            self._said.add(text)
            self._say(text)
