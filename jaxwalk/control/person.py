"""Who walks: a body's proportions, the controllers' numbers scaled to it, and what it bears."""

from __future__ import annotations

import jax
import jax.numpy as jnp
from flax import struct
from jaxtyping import Array, Float

from jaxwalk.config import BodyConfig, GaitConfig
from jaxwalk.control import scaling
from jaxwalk.model import anthropometry, engine, kinematics
from jaxwalk.model.burdens import Burden
from jaxwalk.model.engine import Setup
from jaxwalk.model.similarity import Similarity


class Person(struct.PyTreeNode):
    """What one walker is: constant for its life.

    Attributes:
      ratio: its body's size and mass against the reference body.
      gait: the controllers' numbers, scaled to it.
      burden: what it bears that they do not know of; None for nothing, at no cost.
    """

    ratio: Similarity
    gait: GaitConfig
    burden: Burden | None = None

    @classmethod
    def of(
        cls,
        config: GaitConfig,
        height: Float[Array, ""],
        mass: Float[Array, ""],
        burden: Burden | None = None,
    ) -> Person:
        """A walker of ``height`` m and ``mass`` kg, with what it bears."""
        ratio = Similarity.of(height, mass)
        # Strong types: a weakly typed leaf would make the same program compile twice.
        numbers = jax.tree.map(lambda x: jnp.asarray(x, jnp.float32), scaling.scaled(config, ratio))
        return cls(ratio, numbers, burden)


class Inertias(struct.PyTreeNode):
    """What the toe-off torque moves (eqs 16 and 20).

    Attributes:
      torso: of the torso about the hip, kg m^2.
      leg_mass: of each half of the trailing leg (thigh; shank with foot), kg.
      damping: passive ankle damping c, N m s/rad.
    """

    torso: Float[Array, ""]
    leg_mass: Float[Array, ""]
    damping: Float[Array, ""]


def reference_body(setup: Setup) -> anthropometry.Body:
    """The reference body, whose lengths, gains and torques the configuration gives."""
    return anthropometry.build(BodyConfig(table=setup.body.table))


def skeleton(setup: Setup, person: Person) -> kinematics.Skeleton:
    """The lengths of ``person``'s body, m."""
    return kinematics.skeleton(reference_body(setup), person.ratio.length)


def inertias(setup: Setup, person: Person) -> Inertias:
    """``person``'s inertias for the toe-off equations; the torso is the paper's box, m h^2 / 3."""
    reference = reference_body(setup)
    return Inertias(
        torso=reference.torso.mass * reference.torso.length**2 / 3 * person.ratio.inertia,
        leg_mass=(reference.thigh.mass + reference.shank.mass + reference.foot.mass) / 2 * person.ratio.mass,
        damping=setup.physics.ankle_damping * person.ratio.rotational_damping,
    )


def model_of(setup: Setup, person: Person) -> engine.Model:
    """``person``'s body, for ``setup``'s engine."""
    return engine.model(setup, person.ratio, person.burden)
