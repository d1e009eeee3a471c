"""What stands between the topics and the controller: frames put together, their age and sense, and safety.

Safe means passive joints, and that for good: nothing but a simulation that begins again brings the
controller back. The last command is never repeated.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from jaxwalk.common.errors import UserError
from jaxwalk.deploy import Controller
from jaxwalk.ros import wire
from jaxwalk.ros.body import Body
from jaxwalk.ros.wire import Frame

OLDEST = 20_000_000  # ns for which the walker may be controlled without news of it


class Collector:
    """Messages of one time, from all sensor topics, to one frame."""

    def __init__(self) -> None:
        self._before: dict[str, int] = {}  # the newest stamp of topics that have not followed a new beginning
        self._begin()

    def _begin(self) -> None:
        self._parts: dict[int, dict[str, Any]] = {}
        self._first: dict[str, int] = {}  # stamps of this walk, by topic
        self._newest: dict[str, int] = {}
        self.last = -1

    def take(self, topic: str, stamp: int, values: dict[str, Any]) -> Frame | None:
        """What ``topic`` says of ``stamp`` (ns); a frame where it is the last that was missing.

        Messages of a time that has gone by are left out; time 0 is a new beginning. Topics come in an order
        each, not one among them: what one of them still says of the walk before is left out, too.
        """
        if stamp == 0 and (topic in self._newest or any(self._first.values())):
            self._before |= self._newest
            self._before.pop(topic, None)
            self._begin()
        if self._is_of_before(topic, stamp):
            return None
        self._first.setdefault(topic, stamp)
        self._newest[topic] = max(stamp, self._newest.get(topic, -1))
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

    def _is_of_before(self, topic: str, stamp: int) -> bool:
        if topic not in self._before:
            return False
        # Who goes on upwards has not begun again; but no message is under way for so long: its 0 was lost.
        if stamp > self._before[topic] and max(self._newest.values(), default=0) <= OLDEST:
            self._before[topic] = stamp
            return True
        del self._before[topic]
        return False


def check(controller: Controller, body: Body, policy: str, file: str) -> None:
    """See that ``controller``, of the file ``policy``, speaks to the joints of ``body``, of ``file``.

    Raises:
      UserError: its legs are told no torques, or its ticks are others.
    """
    if controller.person.gait.form != "compliant":
        raise UserError(
            f"policy {policy}: joints are told torques: give a policy of legs that yield, as shipped"
        )
    given, wanted = body.tree.timestep, controller.timestep
    if abs(given - wanted) > 1e-9:
        raise UserError(
            f"{file}: ticks of {given:g} s, but the policy's are of {wanted:g} s: "
            "give the body and the policy that one jaxwalk ros wrote"
        )


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
        begins = self._last < 0 or frame.nanoseconds <= self._last  # it went back, and its 0 was lost
        late = frame.nanoseconds - self._last > OLDEST
        self._last = frame.nanoseconds
        if self.safe:
            return wire.PASSIVE
        if begins and frame.nanoseconds > 0:
            return self._rest("the walk was under way before this controller was")
        if not frame.finite:
            return self._rest("a sensor says what is not a number")
        if not begins and late:
            return self._rest(f"no sensors for more than {OLDEST // 1_000_000} ms")
        try:
            said = wire.sensors(frame)
            command = self._controller.start(said, self._stance) if begins else self._controller.tick(said)
            passive, fallen = self._controller.passive, self._controller.fallen
        except (UserError, ValueError, RuntimeError) as error:  # of numbers that nobody has foreseen, too
            return self._rest(f"the controller has no answer: {error}")
        if passive:
            return self._rest("sensors say what cannot be true")
        if fallen:
            return self._rest("the walker has fallen")
        if not all(map(math.isfinite, told := tuple(map(float, command)))):
            return self._rest("the policy's command is not a number")
        return told

    def refuse(self, why: str) -> tuple[float, ...]:
        """[6] the command after a message that is none: ``why`` is said if joints were not passive."""
        return wire.PASSIVE if self.safe else self._rest(why)

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
