"""What joints and soles do within one tick, as a force plate and inverse dynamics would tell it."""

from __future__ import annotations

import jax.numpy as jnp
from flax import struct
from jaxtyping import Array, Float
from mujoco import mjx

from jaxwalk.model import kinematics
from jaxwalk.model.kinematics import Skeleton
from jaxwalk.model.mjcf import Layout
from jaxwalk.model.physics import Plant


class Forces(struct.PyTreeNode):
    """Means over one tick, so that force times rate times time step is work, exactly.

    Attributes:
      torque: [2, 3] of the actuators at hip, knee, ankle of each leg, N m; flexion and
        dorsiflexion positive, as for the angles.
      damping: [2] passive torque of each ankle, N m.
      rates: [2, 3] of the joints, rad/s.
      ground: [2, 2] of the ground on each foot: forward, upward, N.
      contact_power: of the ground on the body, W: what landing, sliding and sinking take (negative).
    """

    torque: Float[Array, "2 3"]
    damping: Float[Array, "2"]
    rates: Float[Array, "2 3"]
    ground: Float[Array, "2 2"]
    contact_power: Float[Array, ""]


def of_tick(where: Layout, body: Skeleton, plant: Plant, made_with: mjx.Model, data: mjx.Data) -> Forces:
    """The forces of a tick, out of what it was made with and what MJX knows of it.

    The integrator is implicit in the joint rates: servos and dampers act with the rates of the
    tick's end, and so they are counted here.

    Args:
      where: joints lie. plant: at the tick's start.
      made_with, data: what `physics.advance` gave for it.
    """
    gained = data.qvel - plant.qvel
    torque = data.actuator_force + made_with.actuator_biasprm[:, 2] * where.actuated(gained)
    passive = -made_with.dof_damping * data.qvel
    mean = 0.5 * (plant.qvel + data.qvel)
    return Forces(
        torque=torque[:6].reshape(2, 3),
        damping=where.sagittal(passive)[:, 2],
        rates=where.sagittal(mean),
        ground=_ground(where, body, plant, data),
        contact_power=jnp.dot(data.qfrc_constraint, mean),
    )


def _ground(where: Layout, body: Skeleton, plant: Plant, data: mjx.Data) -> Float[Array, "2 2"]:
    """Upward: the sole's touch sensor. Forward: from the contacts' moments about knee and ankle.

    Their difference is that of the force about the knee when it acts at the ankle: with r from knee
    to ankle, r_z F_x - r_x F_z. A straight leg is no obstacle, the shank being upright enough.
    """
    upward = data.sensordata[9:11]
    _, knee, ankle = where.sagittal(data.qfrc_constraint).T
    shank = kinematics.shank_angles(where.sagittal(plant.qpos), plant.qpos[2])
    forth, down = body.shank * jnp.sin(shank), -body.shank * jnp.cos(shank)
    # The ankle's axis points the other way: its moment is counted as dorsiflexion.
    forward = (knee + ankle + forth * upward) / down
    return jnp.stack([forward, upward], axis=1)
