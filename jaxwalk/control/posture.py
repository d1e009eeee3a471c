"""Where the legs are and where the body falls to, by the sensors alone."""

from __future__ import annotations

import jax.numpy as jnp
from flax import struct
from jaxtyping import Array, Float

from jaxwalk.config import GRAVITY
from jaxwalk.control.sensors import Estimate
from jaxwalk.model import anthropometry
from jaxwalk.model.kinematics import Skeleton, ankles, shank_angles, thigh_angles

TORSO_SHARE = anthropometry.WINTER["torso"][0]  # of the body's mass: how far its lean moves the whole


class Posture(struct.PyTreeNode):
    """One walker's.

    Attributes:
      thigh, shank: [2] from the vertical, forward positive, rad.
      ankle, drop: [2] of the ankles, ahead of the hip and below it, m.
      capture: the capture point ahead of the hip, m.
    """

    thigh: Float[Array, "2"]
    shank: Float[Array, "2"]
    ankle: Float[Array, "2"]
    drop: Float[Array, "2"]
    capture: Float[Array, ""]


def of(body: Skeleton, estimate: Estimate) -> Posture:
    """The posture that ``estimate`` tells of."""
    ahead, up = ankles(body, estimate.joints, estimate.pitch)
    return Posture(
        thigh=thigh_angles(estimate.joints, estimate.pitch),
        shank=shank_angles(estimate.joints, estimate.pitch),
        ankle=ahead,
        drop=-up,
        capture=capture_point(body, estimate),
    )


def falling_rate(body: Skeleton) -> Float[Array, ""]:
    """w0 = sqrt(g / L), at which a body that stands on one leg falls, 1/s."""
    return jnp.sqrt(GRAVITY / body.leg)


def capture_point(body: Skeleton, estimate: Estimate) -> Float[Array, ""]:
    """Where a foot would bring the body to rest, m ahead of the hip: v / w0 ahead of its centre of mass
    (Koolen et al. 2012)."""
    lean = TORSO_SHARE * body.torso * jnp.sin(estimate.pitch)
    return lean + estimate.speed * jnp.sqrt(body.leg / GRAVITY)
