"""Pushes: an impulse delivered as a constant force over a duration, somewhere on the torso."""

from __future__ import annotations

import jax.numpy as jnp
from flax import struct
from jaxtyping import Array, Bool, Float, Int


@struct.dataclass
class Push:
    """One push on one walker.

    Attributes:
      start: tick at which it begins (far future: none).
      ticks: how many ticks it lasts.
      force: N, forward positive.
      height: of the point pushed above the torso's centre, m.
    """

    start: Int[Array, ""]
    ticks: Int[Array, ""]
    force: Float[Array, ""]
    height: Float[Array, ""]


NEVER = 2**30


def none() -> Push:
    """No push."""
    return Push(jnp.int32(NEVER), jnp.int32(1), jnp.float32(0), jnp.float32(0))


def whole_ticks(duration: float, timestep: float) -> int:
    """Ticks of a push of about ``duration`` s, at least one."""
    return max(1, round(duration / timestep))


def of_impulse(
    impulse: Float[Array, ""],
    start: Int[Array, ""],
    duration: float,
    timestep: float,
    height: Float[Array, ""],
) -> Push:
    """A push of ``impulse`` N s spread over the whole ticks nearest to ``duration`` s.

    The force is set by the ticks it really lasts, so the impulse asked for is delivered.
    """
    ticks = whole_ticks(duration, timestep)
    return Push(start, jnp.int32(ticks), impulse / (ticks * timestep), height)


def active(push: Push, tick: Int[Array, ""]) -> Bool[Array, ""]:
    """Whether the push acts during ``tick``."""
    return (tick >= push.start) & (tick < push.start + push.ticks)


def wrench(push: Push, tick: Int[Array, ""], pitch: Float[Array, ""]) -> Float[Array, "2"]:
    """[2] forward force (N) and pitching moment about the torso's centre of mass (N m)."""
    force = jnp.where(active(push, tick), push.force, 0.0)
    return jnp.stack([force, force * push.height * jnp.cos(pitch)])
