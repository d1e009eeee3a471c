"""Where hips, ankles and torso are, from joint angles alone."""

from __future__ import annotations

import jax.numpy as jnp
from flax import struct
from jaxtyping import Array, Float

from jaxwalk.model.anthropometry import Body


class Skeleton(struct.PyTreeNode):
    """Lengths of one walker, m.

    Attributes:
      thigh, shank, foot: hip to knee, knee to ankle, ankle to sole.
      torso: hip to the torso's centre of mass.
    """

    thigh: Float[Array, ""]
    shank: Float[Array, ""]
    foot: Float[Array, ""]
    torso: Float[Array, ""]

    @property
    def leg(self) -> Float[Array, ""]:
        """Hip height of a straight leg, L."""
        return self.thigh + self.shank + self.foot


def skeleton(reference: Body, height_ratio: Float[Array, ""]) -> Skeleton:
    """The lengths of a body ``height_ratio`` times as tall as ``reference``."""
    return Skeleton(
        thigh=reference.thigh.length * height_ratio,
        shank=reference.shank.length * height_ratio,
        foot=reference.foot.length * height_ratio,
        torso=reference.torso.com[1] * height_ratio,
    )


def thigh_angles(joints: Float[Array, "2 3"], pitch: Float[Array, ""]) -> Float[Array, "2"]:
    """[2] thigh from the vertical, forward positive, rad."""
    return joints[:, 0] - pitch


def shank_angles(joints: Float[Array, "2 3"], pitch: Float[Array, ""]) -> Float[Array, "2"]:
    """[2] shank from the vertical, forward positive, rad."""
    return joints[:, 0] - pitch - joints[:, 1]


def ankles(
    body: Skeleton, joints: Float[Array, "2 3"], pitch: Float[Array, ""]
) -> tuple[Float[Array, "2"], Float[Array, "2"]]:
    """[2] x and [2] z of the ankles from the hip, m (x forward, z up)."""
    thigh, shank = thigh_angles(joints, pitch), shank_angles(joints, pitch)
    x = body.thigh * jnp.sin(thigh) + body.shank * jnp.sin(shank)
    z = -(body.thigh * jnp.cos(thigh) + body.shank * jnp.cos(shank))
    return x, z
