"""What a joint can do at each rate: a young man's strength, or a powered exoskeleton's motors.

One curve for both, that of Anderson, Madigan and Nussbaum, "Maximum voluntary joint torque as a function of
joint angle and angular velocity" (J. Biomech. 40, 2007), eq. 9, at the joint's best angle:

    torque(w) = most (2 c d + w (d - 3 c)) / (2 c d + w (2 d - 4 c))

with three quarters of the torque left at the rate c, half of it at d; against the motion, all of it. With
d = 2 c it is the straight line of an electric motor, whose no-load rate is 4 c.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from jaxwalk.config import GRAVITY, REFERENCE_HEIGHT, REFERENCE_MASS, Actuators
from jaxwalk.model.similarity import Similarity

_WEIGHT = REFERENCE_MASS * GRAVITY * REFERENCE_HEIGHT


@dataclass(frozen=True)
class Strength:
    """Of hip, knee and ankle of the reference body, each way: (forward, flexed, dorsiflexed), then the other.

    Attributes:
      most: [2, 3] largest torque, N m.
      three_quarters, half: [2, 3] rates at which so much of it is left, rad/s.
    """

    most: tuple[tuple[float, ...], ...]
    three_quarters: tuple[tuple[float, ...], ...]
    half: tuple[tuple[float, ...], ...]


def _motor(torque: float, rate: float) -> Strength:
    """The same motor in each joint: ``torque`` N m at most, ``rate`` rad/s without load."""
    most, c, d = torque, rate / 4, rate / 2
    return Strength(((most,) * 3,) * 2, ((c,) * 3,) * 2, ((d,) * 3,) * 2)


STRENGTHS: dict[str, Strength] = {
    # Their table 3, men of 18 to 25: C1 in shares of body weight x stature, C4 and C5 in rad/s.
    "person": Strength(
        most=(
            (0.113 * _WEIGHT, 0.087 * _WEIGHT, 0.033 * _WEIGHT),
            (0.161 * _WEIGHT, 0.163 * _WEIGHT, 0.095 * _WEIGHT),
        ),
        three_quarters=((2.095, 2.008, 0.699), (1.578, 1.517, 0.987)),
        half=((4.267, 5.233, 1.940), (3.190, 3.952, 3.558)),
    ),
    # Griffin et al., "Using powered ankles: Mina v2 at the 2016 Cybathlon" (IEEE Robotics & Automation
    # Magazine, December 2017): each joint's actuator, 110 N m at most, 9 rad/s without load.
    "exoskeleton": _motor(110.0, 9.0),
}


def peak(actuators: Actuators, joint: int) -> float | None:
    """The largest torque of joint 0, 1 or 2 (hip, knee, ankle) of the reference body, either way, N m; None
    where no limit is set."""
    if actuators == "unlimited":
        return None
    return max(way[joint] for way in STRENGTHS[actuators].most)


def limited(
    actuators: Actuators, body: Similarity, torque: Float[Array, "6"], rate: Float[Array, "6"]
) -> Float[Array, "6"]:
    """``torque`` N m as far as the joints of ``body`` can give it while they turn at ``rate`` rad/s.

    Args:
      torque, rate: [6] hip, knee, ankle; left, right. The reference body's torques grow with mass and
        stature, its rates with the similar body's.
    """
    if actuators == "unlimited":
        return torque
    own, turning = STRENGTHS[actuators], rate.reshape(2, 3) / body.rate
    forth = body.torque * _left(own, 0, turning)
    back = body.torque * _left(own, 1, -turning)
    return jnp.clip(torque.reshape(2, 3), -back, forth).reshape(6)


def of_share(
    actuators: Actuators,
    body: Similarity,
    share: Float[Array, ""],
    torque: Float[Array, "6"],
    rate: Float[Array, "6"],
) -> Float[Array, "6"]:
    """``torque`` N m as far as motors of ``share`` of their strength, at most 1, give it: see `limited`."""
    return jnp.where(share < 1, share * limited(actuators, body, torque / share, rate), torque)


def _left(own: Strength, way: int, rate: Any) -> Any:
    """[2, 3] what is left of the largest torque of both legs at ``rate`` rad/s that way, N m."""
    most, c, d = (np.array(x[way], np.float32) for x in (own.most, own.three_quarters, own.half))
    w = jnp.maximum(rate, 0.0)
    share = (2 * c * d + w * (d - 3 * c)) / (2 * c * d + w * (2 * d - 4 * c))
    return most * jnp.maximum(share, 0.0)
