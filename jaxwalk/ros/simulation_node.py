"""The simulation node, in Gazebo's place: the walker in ODE, its topics, and Gazebo's services.

python3 -m jaxwalk.ros.simulation_node _body:=body.json _seconds:=60
"""

from __future__ import annotations

import sys
import threading
import time
from pathlib import Path
from typing import Any

import rospy
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64
from std_srvs.srv import Empty, EmptyResponse

from jaxwalk.common import files
from jaxwalk.ros import body as bodies
from jaxwalk.ros import gazebo, measures, node, topics, wire
from jaxwalk.ros.inbox import Inbox
from jaxwalk.ros.parameters import Simulated
from jaxwalk.ros.simulation import Simulation, unfit

NAME = "jaxwalk_simulation"


class Node:
    """A `Simulation` between the topics."""

    def __init__(self, told: Simulated) -> None:
        self._told, self._lock = told, threading.RLock()
        body = bodies.read(told.body)
        self._simulation = Simulation(body, "quick" if told.method == "quick" else "world")
        self._inbox = Inbox(len(body.joints), node.say(NAME))
        self._running = threading.Event()
        self._running.set()
        self._again = threading.Event()  # to begin again was asked for
        self._clock = topics.publisher("/clock", Clock)
        self._out = {topic: topics.publisher(topic, kind) for topic, kind in topics.KINDS.items()}
        self._in = [
            topics.subscriber(wire.command(joint), Float64, self._take, row)
            for row, joint in enumerate(body.joints)
        ]
        for name, kind, answer in (
            ("apply_joint_effort", gazebo.service("ApplyJointEffort"), self._effort),
            ("apply_body_wrench", gazebo.service("ApplyBodyWrench"), self._wrench),
            ("reset_simulation", Empty, self._reset),
            ("pause_physics", Empty, self._pause),
            ("unpause_physics", Empty, self._unpause),
        ):
            rospy.Service(f"/gazebo/{name}", kind, answer)

    def _take(self, message: Any, row: int) -> None:
        self._inbox.put(row, message.data, message._connection_header["callerid"])

    def _effort(self, asked: Any) -> Any:
        begin, lasts = asked.start_time.to_nsec(), asked.duration.to_nsec()
        with self._lock:
            wrong = self._simulation.effort(asked.joint_name, asked.effort, begin, lasts)
        return gazebo.service("ApplyJointEffort")._response_class(not wrong, wrong)

    def _wrench(self, asked: Any) -> Any:
        parts = asked.reference_point, asked.wrench.force, asked.wrench.torque
        point, force, torque = ((one.x, one.y, one.z) for one in parts)
        begin, lasts = asked.start_time.to_nsec(), asked.duration.to_nsec()
        wrong = unfit(asked.reference_frame, point, force, torque)
        if not wrong:
            with self._lock:
                wrong = self._simulation.wrench(asked.body_name, force[0], torque[1], begin, lasts)
        return gazebo.service("ApplyBodyWrench")._response_class(not wrong, wrong)

    def _reset(self, _: Any) -> Any:
        """Ask the loop for it: only there is nothing on its way that answers the walk before.

        Who asked may go on to other services, whose loads are the new walk's; so he waits, if not for ever.
        """
        self._again.set()
        end = time.monotonic() + 2 * self._told.patience
        while self._again.is_set() and time.monotonic() < end:
            time.sleep(0.001)
        return EmptyResponse()

    def _pause(self, _: Any) -> Any:
        self._running.clear()
        return EmptyResponse()

    def _unpause(self, _: Any) -> Any:
        self._running.set()
        return EmptyResponse()

    def _publish(self) -> None:
        frame = self._simulation.frame
        self._inbox.open(frame.nanoseconds)
        for topic, message in topics.messages(frame, self._simulation.body.joints).items():
            self._out[topic].publish(message)
        self._clock.publish(Clock(topics.time(frame.nanoseconds)))

    def _met(self) -> bool:
        """Whether the controller and all listeners are there; ten times as long waited for as a command."""
        end = time.monotonic() + 10 * self._told.patience
        while time.monotonic() < end and not rospy.is_shutdown():
            heard = min(one.get_num_connections() for one in self._out.values())
            if heard >= self._told.listeners and all(one.get_num_connections() for one in self._in):
                return True
            time.sleep(0.02)
        return False

    def _record(self) -> measures.Record:
        return measures.Record(self._simulation.body.tree.timestep)

    def _begin_again(self) -> None:
        with self._lock:
            self._simulation.reset()
            self._inbox.clear()
            self._publish()
        self._again.clear()

    def walk(self) -> measures.Record:
        """Ticks until time is over, the walker has fallen, or ROS ends; what came of them since a reset."""
        if not self._met():
            node.say(NAME)("no controller is there: joints are passive")
        with self._lock:
            self._publish()
        record, begun, ticks = self._record(), time.monotonic(), 0
        while not rospy.is_shutdown():
            if not self._running.is_set() and not self._again.is_set():
                self._running.wait(0.1)
                begun, ticks = time.monotonic(), 0
                continue
            ticks += 1
            if self._told.lockstep:
                command = self._inbox.wait(self._told.patience)
            else:
                due = begun + ticks * self._simulation.body.tree.timestep / self._told.factor
                time.sleep(max(0.0, due - time.monotonic()))
                command = self._inbox.newest(self._simulation.now)
            if self._again.is_set():
                # In lock-step the answer to the last frame has come, and is not taken for that to frame 0.
                self._begin_again()
                record, begun, ticks = self._record(), time.monotonic(), 0
                continue
            with self._lock:
                self._simulation.tick(command)
                record.add(self._simulation.qpos, command, self._inbox.latency, time.monotonic())
                self._publish()
            if record.fallen or (self._told.seconds and self._simulation.now >= self._told.seconds * 1e9):
                break
        return record


def main() -> int:
    """Run the node."""
    told = node.begin(NAME, Simulated)
    record = Node(told).walk()
    if told.report:
        files.write_json(Path(told.report), record.told(told.factor))
    return 0


if __name__ == "__main__":
    sys.exit(node.run(main))
