"""The controller node: sensors' topics in, joints' commands out, by NumPy and rospy alone.

python3 -m jaxwalk.ros.controller_node _policy:=policy.safetensors _body:=body.json
"""

from __future__ import annotations

import os
import sys
import threading
import time
from typing import Any, TextIO

import rospy
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64

from jaxwalk.deploy import Controller
from jaxwalk.ros import body as bodies
from jaxwalk.ros import node, topics, watch, wire
from jaxwalk.ros.parameters import Controlled
from jaxwalk.ros.watch import OLDEST, Collector, Keeper

NAME = "jaxwalk_controller"


class Node:
    """A `Keeper` between the topics."""

    def __init__(self, told: Controlled, lines: TextIO) -> None:
        body = bodies.read(told.body)
        controller = Controller.load(told.policy, delay=told.delay)
        watch.check(controller, body, told.policy, told.body)
        self._keeper = Keeper(controller, body.stance, node.say(NAME))
        self._collector, self._lock = Collector(), threading.Lock()
        self._heard = time.monotonic()
        self._lines = lines
        self._names = body.joints
        self._joints = [topics.publisher(wire.command(joint), Float64) for joint in body.joints]
        for topic, kind in topics.KINDS.items():
            topics.subscriber(topic, kind, self._take, topic)
        topics.subscriber("/clock", Clock, self._clock)
        if not told.lockstep:
            threading.Thread(target=self._wait, args=[told.factor], daemon=True).start()

    def _take(self, message: Any, topic: str) -> None:
        with self._lock:
            stamp = message.header.stamp.to_nsec()
            try:
                values = topics.values(topic, message, self._names)
            except ValueError as error:
                self._give(self._keeper.refuse(str(error)))
                return
            frame = self._collector.take(topic, stamp, values)
            if frame is None:
                return
            self._heard = time.monotonic()
            self._give(self._keeper.answer(frame))

    def _clock(self, message: Any) -> None:
        with self._lock:
            if self._keeper.watch(message.clock.to_nsec()):
                self._give(wire.PASSIVE)

    def _wait(self, factor: float) -> None:
        """Nobody may say what time it is: then one's own clock tells how old the news are."""
        while not rospy.is_shutdown():
            time.sleep(OLDEST / 4e9 / factor)
            with self._lock:
                silent = int((time.monotonic() - self._heard) * factor * 1e9)
                if self._keeper.watch(self._collector.last + silent):
                    self._give(wire.PASSIVE)

    def _give(self, command: tuple[float, ...]) -> None:
        for joint, value in zip(self._joints, command, strict=True):
            joint.publish(topics.command(value))
        # After the joints: a disk that is full is no reason to let the walker wait.
        self._lines.write(" ".join(map(float.hex, command)) + "\n")
        self._lines.flush()


def main() -> int:
    """Run the node until ROS ends it."""
    told = node.begin(NAME, Controlled)
    with open(told.commands or os.devnull, "w", encoding="utf-8") as lines:
        Node(told, lines)
        rospy.spin()
    return 0


if __name__ == "__main__":
    sys.exit(node.run(main))
