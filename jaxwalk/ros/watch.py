"""What stands between the topics and the controller: frames put together, their age and sense, and safety.

Safe means passive joints, and that for good: nothing but a simulation that begins again brings the
controller back. The last command is never repeated.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from jaxwalk.deploy import Controller
from jaxwalk.ros import wire
from jaxwalk.ros.wire import Frame

OLDEST = 20_000_000  # ns for which the walker may be controlled without news of it


class Collector:
    """Messages of one time, from all sensor topics, to one frame."""

    def __init__(self) -> None:
        self._parts: dict[int, dict[str, Any]] = {}
        self.last = -1

    def take(self, topic: str, stamp: int, values: dict[str, Any]) -> Frame | None:
        """What ``topic`` says of ``stamp`` (ns); a frame where it is the last that was missing.

        Messages of a time that has gone by are left out; time 0 is a new beginning.
        """
        if stamp == 0 and self.last > 0:
            self.__init__()
        if stamp <= self.last:
            return None
        parts = self._parts.setdefault(stamp, {})
        parts[topic] = values
        if len(parts) < len(wire.SENSORS):
            return None
        self.last = stamp
        self._parts = {when: rest for when, rest in self._parts.items() if when > stamp}
        touch = tuple(parts[foot]["touch"] for foot in wire.FEET)
        told = {name: value for topic in wire.SENSORS[:3] for name, value in parts[topic].items()}
        return Frame(stamp, **told, touch=touch)


class Keeper:
    """A controller that is asked only what it can answer.

    Args:
      stance: the foot that has landed at the start.
      say: called with one line when joints become passive.

    Attributes:
      safe: the joints are passive, and stay so.
    """

    def __init__(self, controller: Controller, stance: int, say: Callable[[str], None]) -> None:
        self._controller, self._stance, self._say = controller, stance, say
        self._last = -1
        self.safe = False

    def answer(self, frame: Frame) -> tuple[float, ...]:
        """[6] the command for ``frame``."""
        if frame.nanoseconds == 0:
            self._last, self.safe = -1, False
        begins, late = self._last < 0, frame.nanoseconds - self._last > OLDEST
        self._last = frame.nanoseconds
        if self.safe:
            return wire.PASSIVE
        if begins and frame.nanoseconds > 0:
            return self._rest("the walk was under way before this controller was")
        if not frame.finite:
            return self._rest("a sensor says what is not a number")
        if not begins and late:
            return self._rest(f"no sensors for more than {OLDEST // 1_000_000} ms")
        said = wire.sensors(frame)
        command = self._controller.start(said, self._stance) if begins else self._controller.tick(said)
        if not all(map(math.isfinite, told := tuple(map(float, command)))):
            return self._rest("the policy's command is not a number")
        return told

    def watch(self, now: int) -> bool:
        """Whether at ``now`` (ns, of the frames' clock) it has just become too long since the last frame."""
        if self.safe or self._last < 0 or now - self._last <= OLDEST:
            return False
        self._rest(f"no sensors for more than {OLDEST // 1_000_000} ms")
        return True

    def _rest(self, why: str) -> tuple[float, ...]:
        self.safe = True
        self._say(f"safe state, joints are passive: {why}")
        return wire.PASSIVE
