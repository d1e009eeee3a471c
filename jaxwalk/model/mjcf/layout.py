"""Where in a model's vectors things lie: static under jit, so that both bodies share every program's code.

Each model begins with hip x, hip height and torso pitch, and moves each leg in the sagittal plane by
hip, knee and ankle. What it has beyond that lies between: joints of the root, and of each leg.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeVar

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from jaxwalk.config import BodyModel

SIDES = ("left", "right")
SEGMENTS = ("torso",) + tuple(
    f"{segment}_{side}" for side in SIDES for segment in ("thigh", "shank", "foot")
)  # the bodies, after the world
SAGITTAL = ("hip", "knee", "ankle")
X = TypeVar("X", bound=Array | np.ndarray)


@dataclass(frozen=True)
class Layout:
    """How one model numbers its joints; positions, velocities and degrees of freedom alike.

    Attributes:
      root: joints of the root; the first three are hip x and height (m), torso pitch (rad).
      leg: joints of each leg, in order.
      held: of those, the one that a servo of its own holds still; None for none.
      walls: the sensors end with the force on each wall.
    """

    root: tuple[str, ...]
    leg: tuple[str, ...]
    held: str | None = None
    walls: bool = False

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of all D joints, in order."""
        return self.root + tuple(f"{joint}_{side}" for side in SIDES for joint in self.leg)

    @property
    def dofs(self) -> int:
        """Degrees of freedom, D."""
        return len(self.joints)

    @property
    def sensed(self) -> int:
        """Numbers that the sensors give."""
        return 13 if self.walls else 11

    def sagittal(self, joints: Float[X, "*B D"]) -> Float[X, "*B 2 3"]:
        """[..., 2, 3] hip, knee and ankle of each leg, out of all joints' [..., D]; NumPy or JAX."""
        first = self.leg.index(SAGITTAL[0])
        legs: Any = joints[..., len(self.root) :].reshape(*joints.shape[:-1], 2, len(self.leg))
        return legs[..., first : first + 3]

    def planar(self, joints: Float[Array | np.ndarray, "*B D"]) -> np.ndarray:
        """[..., 9] those of the planar model, out of all joints' [..., D]: the walk as seen from the side."""
        legs = np.asarray(self.sagittal(joints)).reshape(*joints.shape[:-1], 6)
        return np.concatenate([joints[..., :3], legs], axis=-1)

    def actuated(self, joints: Float[Array | np.ndarray, "D"]) -> Float[Array | np.ndarray, "A"]:
        """[A] those that an actuator moves, in the actuators' order, out of all joints' [D]."""
        commanded = self.sagittal(joints).reshape(6)
        if self.held is None:
            return commanded
        legs = joints[len(self.root) :].reshape(2, len(self.leg))
        return jnp.concatenate([commanded, legs[:, self.leg.index(self.held)]])

    def control(self, command: Float[Array, "6"]) -> Float[Array, "A"]:
        """[A] the controllers' command for all actuators: a joint that is held is told to stand still."""
        return command if self.held is None else jnp.concatenate([command, jnp.zeros(2)])

    def vector(self, root: Float[Array, "3"], sagittal: Float[Array, "2 3"]) -> Float[Array, "D"]:
        """[D] all joints, given those that move in the plane; the others are 0."""
        first = self.leg.index(SAGITTAL[0])
        beyond = (0, 0), (first, len(self.leg) - first - 3)
        return jnp.concatenate(
            [root, jnp.zeros(len(self.root) - 3), jnp.pad(sagittal, beyond).reshape(2 * len(self.leg))]
        )


_ROOT = ("root_x", "root_z", "root_pitch")
PLANAR = Layout(_ROOT, SAGITTAL)
WALLS = Layout(
    (*_ROOT, "root_y", "root_roll", "root_yaw"), ("abduction", *SAGITTAL, "inversion"), "abduction", True
)
LAYOUTS: dict[BodyModel, Layout] = {"planar": PLANAR, "walls": WALLS}
