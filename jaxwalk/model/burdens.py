"""What a walker bears that neither its controllers nor its policy are told of.

A pack is fixed to the torso: mass, centre of mass and inertia about the pitch axis change by the
parallel-axis theorem. In the plane nothing else of a body's inertia counts; between walls, where it
rolls and yaws little, the other two moments grow in proportion. The contacts stay as hard as they are
without it (MuJoCo's inverse weights, which set that, are the unladen body's).
"""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
from flax import struct
from jaxtyping import Array, Float
from mujoco import mjx

PACK_HEIGHT, PACK_DEPTH = 0.45, 0.20  # m; a rucksack of some 30 l, evenly filled
_GYRATION2 = (PACK_HEIGHT**2 + PACK_DEPTH**2) / 12  # m^2, of a uniform box about its centre


class Burden(struct.PyTreeNode):
    """A burden; fields are floats, or JAX scalars of one walker.

    Attributes:
      mass: of the pack, kg; 0 for none.
      ahead, up: of the pack's centre from the torso's own, along the torso's axes, m.
      force: steady and horizontal, on the torso's own centre, N, forward positive.
      friction: sliding, between sole and floor.
    """

    mass: Any
    ahead: Any
    up: Any
    force: Any
    friction: Any


def laden(mass: Any, inertia: Any, burden: Burden) -> tuple[Any, tuple[Any, Any], Any]:
    """A torso with its pack.

    Args:
      mass: of the torso alone, kg. inertia: about its centre, kg m^2.

    Returns:
      Mass (kg), how far the centre moves (ahead, up; m), inertia about the new centre (kg m^2).
    """
    share = burden.mass / (mass + burden.mass)
    apart = burden.ahead**2 + burden.up**2
    total = inertia + burden.mass * _GYRATION2 + mass * share * apart
    # Sums to which nothing is added when there is no pack: exactly the torso alone.
    return mass + burden.mass, (share * burden.ahead, share * burden.up), total


def onto(model: mjx.Model, burden: Burden) -> mjx.Model:
    """``model`` of an unladen walker, with ``burden``'s pack and floor."""
    own = model.body_inertia[1, 1]
    _, (ahead, up), inertia = laden(model.body_mass[1], own, burden)
    return model.replace(
        body_mass=model.body_mass.at[1].add(burden.mass),
        body_subtreemass=model.body_subtreemass.at[:2].add(burden.mass),  # of the torso and of all
        body_ipos=model.body_ipos.at[1, 0].add(ahead).at[1, 2].add(up),
        body_inertia=model.body_inertia.at[1].multiply(inertia / own),
        pair_friction=model.pair_friction.at[:, :2].set(burden.friction),
    )


def felt(
    burden: Burden, torso_mass: Float[Array, ""], push: Float[Array, "2"], pitch: Float[Array, ""]
) -> Float[Array, "2"]:
    """[2] force (N) and pitching moment (N m) at the laden torso's centre of mass.

    Args:
      torso_mass: without the pack, kg.
      push: [2] the same of a push, at the torso's own centre; the steady force is added to it.
      pitch: of the torso, rad.
    """
    _, (ahead, up), _ = laden(torso_mass, 0.0, burden)
    force = push[0] + burden.force
    above = ahead * jnp.sin(pitch) - up * jnp.cos(pitch)  # the own centre, over the laden one
    return jnp.stack([force, push[1] + force * above])
