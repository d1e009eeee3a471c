"""The step's clock: which leg stands, for how long, and what step it was told to take."""

from __future__ import annotations

import jax.numpy as jnp
from flax import struct
from jaxtyping import Array, Bool, Float, Int

from jaxwalk.control.sensors import Estimate
from jaxwalk.model.kinematics import Skeleton, ankles


class Path(struct.PyTreeNode):
    """Where the swing hip shall be.

    Attributes:
      angle: rad. rate: rad/s.
    """

    angle: Float[Array, ""]
    rate: Float[Array, ""]


class StepClock(struct.PyTreeNode):
    """Where in its step a walker is.

    Attributes:
      stance: index of the stance leg, 0 left, 1 right.
      elapsed: since the last touch-down, s.
      length, duration: commanded, of the step now under way: length (m), and the time of its early swing
        (rigid) or of the whole step (compliant), s.
      toe_off, toe_off_seconds: torque of the trailing ankle (N m, plantarflexion positive) and how long it
        lasts at most (s).
      path: of the swing hip; None for rigid legs.
      change: [2] of the planned length (m) and duration (s), as the policy wants it; None where it commands
        the step itself.
      lag: how far the walker has fallen behind the speed asked for of late, m; None for rigid legs.
    """

    stance: Int[Array, ""]
    elapsed: Float[Array, ""]
    length: Float[Array, ""]
    duration: Float[Array, ""]
    toe_off: Float[Array, ""]
    toe_off_seconds: Float[Array, ""]
    path: Path | None = None
    change: Float[Array, "2"] | None = None
    lag: Float[Array, ""] | None = None

    @property
    def is_stance(self) -> Bool[Array, "2"]:
        """[2] true for the stance leg."""
        return jnp.arange(2) == self.stance


def step_length(body: Skeleton, gait: StepClock, estimate: Estimate) -> Float[Array, ""]:
    """How far the swing ankle is ahead of the stance ankle, m."""
    x, _ = ankles(body, estimate.joints, estimate.pitch)
    return jnp.sum(jnp.where(gait.is_stance, -x, x))


def swing_force(gait: StepClock, estimate: Estimate) -> Float[Array, ""]:
    """The force under the sole of the swing leg, N."""
    return jnp.sum(jnp.where(gait.is_stance, 0.0, estimate.touch))
