"""Pushes: an impulse delivered as a constant force over a duration, somewhere on the body."""

from __future__ import annotations

import jax.numpy as jnp
from flax import struct
from jaxtyping import Array, Bool, Float, Int

from jaxwalk.model.push_points import PLACES


class Push(struct.PyTreeNode):
    """One push on one walker.

    Attributes:
      start: tick at which it begins (far future: none).
      ticks: how many ticks it lasts.
      force: N, forward positive.
      height: of the point pushed above the torso's centre, m; not looked at on a leg.
      place: the segment pushed, an index into `push_points.PLACES`; a leg's at its centre of mass.
      stance: the leg that was in stance when it began, 0 left, 1 right.
      cell: what it is counted as (`jaxwalk.task.course`); before: what the one before it was; -1: nothing.
    """

    start: Int[Array, ""]
    ticks: Int[Array, ""]
    force: Float[Array, ""]
    height: Float[Array, ""]
    place: Int[Array, ""]
    stance: Int[Array, ""]
    cell: Int[Array, ""]
    before: Int[Array, ""]


NEVER = 2**30
TORSO = PLACES.index("torso")


def none() -> Push:
    """A push that never comes."""
    return Push(
        start=jnp.int32(NEVER),
        ticks=jnp.int32(1),
        force=jnp.float32(0),
        height=jnp.float32(0),
        place=jnp.int32(TORSO),
        stance=jnp.int32(0),
        cell=jnp.int32(-1),
        before=jnp.int32(-1),
    )


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
    """A push on the torso of ``impulse`` N s spread over the whole ticks nearest to ``duration`` s.

    The force is set by the ticks it really lasts, so the impulse asked for is delivered.
    """
    ticks = whole_ticks(duration, timestep)
    return none().replace(
        start=start, ticks=jnp.int32(ticks), force=impulse / (ticks * timestep), height=height
    )


def active(push: Push, tick: Int[Array, ""]) -> Bool[Array, ""]:
    """Whether the push acts during ``tick``."""
    return (tick >= push.start) & (tick < push.start + push.ticks)


def met(push: Push, tick: Int[Array, ""], stance: Int[Array, ""]) -> Push:
    """The push as ``tick`` finds it: when it begins, it settles on a leg and keeps to it.

    Args:
      stance: the leg in stance, 0 left, 1 right.
    """
    return push.replace(stance=jnp.where(tick == push.start, stance, push.stance))


def loads(push: Push, tick: Int[Array, ""], pitch: Float[Array, ""]) -> Float[Array, "7 2"]:
    """[7, 2] forward force (N) at each segment's centre of mass and pitching moment about it (N m).

    Segments in the order of `mjcf.SEGMENTS`: torso, then thigh, shank and foot, left and right.
    """
    force = jnp.where(active(push, tick), push.force, 0.0)
    torso = push.place == TORSO
    of_leg = push.place - 1  # thigh and shank of the stance leg, then of the swing leg
    leg = jnp.where(of_leg < 2, push.stance, 1 - push.stance)
    segment = jnp.where(torso, 0, 1 + 3 * leg + of_leg % 2)
    moment = jnp.where(torso, force * push.height * jnp.cos(pitch), 0.0)
    return jnp.where((jnp.arange(7) == segment)[:, None], jnp.stack([force, moment]), 0.0)
