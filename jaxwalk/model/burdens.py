"""What a walker bears that neither its controllers nor its policy are told of: packs, forces, floors, motors.

But for how late its instruments are, which whoever builds them measures: a policy may be told of that
(`jaxwalk.task.footstep`).

A pack is fixed to the torso: mass, centre of mass and inertia about the pitch axis change by the
parallel-axis theorem. In the plane nothing else of a body's inertia counts; between walls, where it
rolls and yaws little, the other two moments grow in proportion. The contacts stay as hard as they are
without it (MuJoCo's inverse weights, which set that, are the unladen body's).

A slope is told along the floor: gravity pulls each segment down it, and the instruments' upright is not the
floor's. What gravity presses less onto the floor, 0.14 % at 3 degrees, is left out.
"""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
from flax import struct
from jaxtyping import Array, Float
from mujoco import mjx

from jaxwalk.config import GRAVITY

PACK_HEIGHT, PACK_DEPTH = 0.45, 0.20  # m; a rucksack of some 30 l, evenly filled
# Centres of packs from the torso's own, (ahead, up), m. On the back: half a trunk (0.09 m) and nearly half a
# pack (0.2 m) behind, at chest height, four fifths of the way from hip to shoulder. In front: as near as
# belly and arms allow, at the height of the torso's centre.
BACKPACK, FRONT_PACK = (-0.18, 0.10), (0.20, 0.0)
_GYRATION2 = (PACK_HEIGHT**2 + PACK_DEPTH**2) / 12  # m^2, of a uniform box about its centre


class Burden(struct.PyTreeNode):
    """A burden; fields are floats, or JAX scalars of one walker.

    Attributes:
      mass: of the pack, kg; 0 for none.
      ahead, up: of the pack's centre from the torso's own, along the torso's axes, m.
      force: steady and horizontal, on the torso's own centre, N, forward positive.
      friction: sliding, between sole and floor.
      slope: of the floor, uphill positive, rad.
      strength: share of their strength that the motors have.
      delay: by which instruments of torso and soles are told late, s; at most `jaxwalk.config.DELAY_MOST`.
    """

    mass: Any
    ahead: Any
    up: Any
    force: Any
    friction: Any
    slope: Any = 0.0
    strength: Any = 1.0
    delay: Any = 0.0


def downhill(masses: Float[Array, "7"], burden: Burden) -> Float[Array, "7"]:
    """[7] N by which gravity pulls each segment along the floor, forward positive.

    Args:
      masses: of the segments in the order of `pushes.loads`, kg, without the pack.
    """
    return -GRAVITY * jnp.sin(burden.slope) * jnp.asarray(masses).at[0].add(burden.mass)


def upright(up: Float[Array, "3"], burden: Burden) -> Float[Array, "3"]:
    """[3] the torso's long axis as gravity tells it, of ``up`` along the floor's axes."""
    c, s = jnp.cos(burden.slope), jnp.sin(burden.slope)
    return jnp.stack([c * up[0] - s * up[2], up[1], s * up[0] + c * up[2]])


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
