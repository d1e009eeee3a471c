"""Dynamic similarity: how every quantity scales with stature and mass.

Two bodies of one shape move alike under one gravity when lengths scale with height h
and times with sqrt(h) (Froude). Ratios are taken to the reference body.
"""

from __future__ import annotations

from typing import Any

from flax import struct

from jaxwalk.config import REFERENCE_HEIGHT, REFERENCE_MASS


class Similarity(struct.PyTreeNode):
    """Ratios to the reference body; fields are floats or JAX scalars of one walker.

    Attributes:
      length: h / h_ref.
      mass: m / m_ref.
    """

    length: Any
    mass: Any

    @classmethod
    def of(cls, height: Any, mass: Any) -> Similarity:
        """Ratios of a body of ``height`` m and ``mass`` kg to the reference body."""
        return cls(height / REFERENCE_HEIGHT, mass / REFERENCE_MASS)

    @property
    def time(self) -> Any:
        """Ratio of times."""
        return self.length**0.5

    @property
    def speed(self) -> Any:
        """Ratio of speeds."""
        return self.length**0.5

    @property
    def rate(self) -> Any:
        """Ratio of angular velocities."""
        return self.length**-0.5

    @property
    def angular_acceleration(self) -> Any:
        """Ratio of angular accelerations."""
        return 1.0 / self.length

    @property
    def torque(self) -> Any:
        """Ratio of torques, and of rotational stiffness."""
        return self.mass * self.length

    @property
    def rotational_damping(self) -> Any:
        """Ratio of rotational damping (N m s/rad)."""
        return self.mass * self.length**1.5

    @property
    def inertia(self) -> Any:
        """Ratio of moments of inertia."""
        return self.mass * self.length**2

    @property
    def force(self) -> Any:
        """Ratio of forces."""
        return self.mass

    @property
    def impulse(self) -> Any:
        """Ratio of impulses (N s)."""
        return self.mass * self.length**0.5
