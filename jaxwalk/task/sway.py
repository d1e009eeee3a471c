"""What a walker does sideways between its walls, and what they do to it: counted per trial, and told."""

from __future__ import annotations

from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np
from flax import struct
from jaxtyping import Array, Float

from jaxwalk.control.walker import Walker
from jaxwalk.model.mjcf import walls
from jaxwalk.task import stepper


class Sway(struct.PyTreeNode):
    """What is counted.

    Attributes:
      play: how far aside of the middle a point of the trunk that can touch a wall has been, m.
      roll_high, roll_low, yaw_high, yaw_low: of the torso, rad.
      force: of both walls, its sum over time, N s. force_most: of one of them, N.
    """

    play: Float[Array, ""]
    roll_high: Float[Array, ""]
    roll_low: Float[Array, ""]
    yaw_high: Float[Array, ""]
    yaw_low: Float[Array, ""]
    force: Float[Array, ""]
    force_most: Float[Array, ""]


def start() -> Sway:
    """Nothing counted yet."""
    zero, high, low = jnp.zeros(()), jnp.float32(-jnp.inf), jnp.float32(jnp.inf)
    return Sway(
        play=zero, roll_high=high, roll_low=low, yaw_high=high, yaw_low=low, force=zero, force_most=zero
    )


def count(sway: Sway, height: Float[Array, ""], body: Walker, seconds: Float[Array, ""]) -> Sway:
    """What is counted after one more tick.

    Args:
      height: of the walker, m.
      seconds: the tick's; 0 for one that is not counted.
    """
    y, roll, yaw = body.plant.qpos[3:6]
    hip = jnp.abs(y) + walls.REACH * height * jnp.cos(roll) * jnp.abs(jnp.sin(yaw))
    shoulder = jnp.abs(y - walls.SHOULDER * height * jnp.sin(roll))
    narrower = walls.BREADTH * height * (1 - jnp.cos(roll) * jnp.cos(yaw))  # a trunk that turns aside
    assert body.walls is not None  # between walls only is anything counted
    counted = Sway(
        play=jnp.maximum(sway.play, jnp.maximum(hip, shoulder) - narrower),
        roll_high=jnp.maximum(sway.roll_high, roll),
        roll_low=jnp.minimum(sway.roll_low, roll),
        yaw_high=jnp.maximum(sway.yaw_high, yaw),
        yaw_low=jnp.minimum(sway.yaw_low, yaw),
        force=sway.force + seconds * jnp.sum(body.walls),
        force_most=jnp.maximum(sway.force_most, jnp.max(body.walls)),
    )
    return stepper.select(seconds > 0, counted, sway)


@dataclass(frozen=True)
class Swayed:
    """What trials between walls came to; means over walkers, and extremes of all.

    Attributes:
      gap: between the trunk in the middle and each wall, m.
      play: how far aside of the middle a point of the trunk that can touch a wall has been, m.
      roll_amplitude, yaw_amplitude: half of peak to peak over the whole walk, rad.
      force_mean: of both walls together, over time, N.
      force_largest: of one wall, N.
    """

    gap: float
    play: float
    roll_amplitude: float
    yaw_amplitude: float
    force_mean: float
    force_largest: float


def report(sway: Sway, seconds: Array | np.ndarray, height: float) -> Swayed:
    """[N] trials of walkers ``height`` m tall, ``seconds`` of each of which were counted."""
    some = seconds > 0
    if not some.any():
        return Swayed(walls.GAP * height, 0.0, 0.0, 0.0, 0.0, 0.0)
    return Swayed(
        gap=walls.GAP * height,
        play=float(sway.play.max()),
        roll_amplitude=float(np.mean((sway.roll_high - sway.roll_low)[some]) / 2),
        yaw_amplitude=float(np.mean((sway.yaw_high - sway.yaw_low)[some]) / 2),
        force_mean=float(sway.force.sum() / seconds.sum()),
        force_largest=float(sway.force_most.max()),
    )
