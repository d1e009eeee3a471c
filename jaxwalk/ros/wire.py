"""What the topics carry, without ROS: one tick's messages as plain numbers, and as a controller takes them.

Commands are the same whether a message went through ROS or not, since both ways pass through here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from jaxwalk.deploy import Sensors

NAMESPACE = "/walker"
IMU, VELOCITY, JOINTS = f"{NAMESPACE}/imu", f"{NAMESPACE}/velocity", f"{NAMESPACE}/joint_states"
FEET = (f"{NAMESPACE}/foot_left", f"{NAMESPACE}/foot_right")
SENSORS = (IMU, VELOCITY, JOINTS, *FEET)
PASSIVE = (math.nan,) * 6
"""The command of joints that nothing moves: what is not a number is no torque."""


def command(joint: str) -> str:
    """The topic of a joint's commands, called as Gazebo's controllers are."""
    return f"{NAMESPACE}/{joint}_effort_controller/command"


@dataclass(frozen=True)
class Frame:
    """All that the instruments say after one tick.

    Attributes:
      nanoseconds: since the start, simulated.
      pitch: (y, w) of the torso's orientation, a quaternion about y.
      pitch_rate: rad/s. acceleration: forward, m/s^2. velocity: forward, m/s; a real IMU has none, it
        would have to be estimated.
      joints, joint_rates: [6] rad and rad/s, left, then right. touch: [2] N.
    """

    nanoseconds: int
    pitch: tuple[float, float]
    pitch_rate: float
    acceleration: float
    velocity: float
    joints: tuple[float, ...]
    joint_rates: tuple[float, ...]
    touch: tuple[float, float]

    @property
    def finite(self) -> bool:
        """Whether all of it are numbers, and the torso's orientation is one."""
        single = *self.pitch, self.pitch_rate, self.acceleration, self.velocity
        told = *single, *self.joints, *self.joint_rates, *self.touch
        return any(self.pitch) and all(map(math.isfinite, told))


def turned(pitch: float) -> tuple[float, float]:
    """(y, w) of the quaternion of ``pitch``, rad."""
    return math.sin(pitch / 2), math.cos(pitch / 2)


def pitch(y: float, w: float) -> float:
    """What `turned` was told, within (-pi, pi]: a quaternion and its negative are one orientation."""
    found = 2 * (math.atan2(-y, -w) if w < 0 else math.atan2(y, w))
    return found if found > -math.pi else math.pi


def states(
    joints: Sequence[str], names: Sequence[str], position: Sequence[float], velocity: Sequence[float]
) -> dict[str, tuple[float, ...]]:
    """What of a frame the joints' states say.

    Args:
      joints: the walker's, in the order that is wanted.
      names, position, velocity: what the message says; rad, rad/s.

    Raises:
      ValueError: other joints, another order, or a joint without an angle or a rate.
    """
    if tuple(names) != tuple(joints):
        raise ValueError(f"{JOINTS} is of {', '.join(names) or 'no joint'}; wanted: {', '.join(joints)}")
    if not len(position) == len(velocity) == len(joints):
        raise ValueError(
            f"{JOINTS} has {len(position)} positions and {len(velocity)} velocities of {len(joints)} joints"
        )
    return {"joints": tuple(position), "joint_rates": tuple(velocity)}


def sensors(frame: Frame) -> Sensors:
    """``frame`` as the controller takes it."""
    return Sensors(
        velocity=frame.velocity,
        acceleration=frame.acceleration,
        pitch=pitch(*frame.pitch),
        pitch_rate=frame.pitch_rate,
        joints=np.array(frame.joints).reshape(2, 3),
        joint_rates=np.array(frame.joint_rates).reshape(2, 3),
        touch=np.array(frame.touch),
    )
