"""Frames to messages and back: the one place that knows ROS's message types."""

from __future__ import annotations

import warnings
from typing import Any

import rospy
from geometry_msgs.msg import TwistStamped, WrenchStamped
from sensor_msgs.msg import Imu, JointState
from std_msgs.msg import Float64

from jaxwalk.ros import wire
from jaxwalk.ros.wire import Frame

KINDS: dict[str, Any] = {
    wire.IMU: Imu,
    wire.VELOCITY: TwistStamped,
    wire.JOINTS: JointState,
    **dict.fromkeys(wire.FEET, WrenchStamped),
}


def publisher(topic: str, kind: Any) -> Any:
    """It sends within `publish`, at once: a queue's thread would add its own delay."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SyntaxWarning)  # of a queue that is meant not to be
        return rospy.Publisher(topic, kind, tcp_nodelay=True)


def subscriber(topic: str, kind: Any, take: Any, told: Any = None) -> Any:
    """``take(message, told)`` is called for each message of ``topic``."""
    return rospy.Subscriber(topic, kind, take, told, tcp_nodelay=True)


def time(nanoseconds: int) -> Any:
    """ROS's, of the simulation's."""
    return rospy.Time(nanoseconds // 1_000_000_000, nanoseconds % 1_000_000_000)


def messages(frame: Frame, joints: tuple[str, ...]) -> dict[str, Any]:
    """The messages of ``frame``, by topic."""
    imu, velocity, states = Imu(), TwistStamped(), JointState()
    imu.orientation.y, imu.orientation.w = frame.pitch
    imu.angular_velocity.y = frame.pitch_rate
    imu.linear_acceleration.x = frame.acceleration
    velocity.twist.linear.x = frame.velocity
    states.name, states.position, states.velocity = list(joints), frame.joints, frame.joint_rates
    feet = [WrenchStamped() for _ in wire.FEET]
    for foot, force in zip(feet, frame.touch, strict=True):
        foot.wrench.force.z = force
    made: dict[str, Any] = dict(zip(wire.SENSORS, (imu, velocity, states, *feet), strict=True))
    for message in made.values():
        message.header.stamp = time(frame.nanoseconds)
    return made


def values(topic: str, message: Any, joints: tuple[str, ...]) -> dict[str, Any]:
    """What of a frame ``message`` tells; a foot's force is told by its own name.

    Raises:
      ValueError: as of `wire.states`.
    """
    if topic == wire.IMU:
        turned = message.orientation
        return {
            "pitch": (turned.y, turned.w),
            "pitch_rate": message.angular_velocity.y,
            "acceleration": message.linear_acceleration.x,
        }
    if topic == wire.VELOCITY:
        return {"velocity": message.twist.linear.x}
    if topic == wire.JOINTS:
        return wire.states(joints, message.name, message.position, message.velocity)
    return {"touch": message.wrench.force.z}


def command(value: float) -> Any:
    """A joint's."""
    return Float64(value)
