"""Gazebo's two ways of moving a joint: a PID on its velocity, and an effort held for a while.

Liu et al. moved their walker by both. The PID is an explicit one, computed once a tick from the joint's
own rate, as Gazebo's ``common::PID`` is: its gain times the tick over the joint's inertia must stay
well below 2, or it chatters between its limits. Both act on every joint that has an actuator; of an
ankle, whose gains are 0 by default, only efforts: the push of toe-off, then the foot's retraction.
"""

from __future__ import annotations

import dataclasses

import jax.numpy as jnp
import numpy as np
from flax import struct
from jaxtyping import Array, Bool, Float, Int

from jaxwalk.config import GaitConfig, PhysicsConfig, PidConfig
from jaxwalk.control.step_clock import StepClock
from jaxwalk.model.mjcf import Layout
from jaxwalk.model.physics import Plant
from jaxwalk.model.similarity import Similarity

_ANKLES = np.array([2, 5])  # among the joints that an actuator moves


class Gains(struct.PyTreeNode):
    """The gains of the PIDs of J joints.

    Attributes:
      proportional: N m s/rad. integral: N m/rad. derivative: kg m^2.
      windup: largest torque of the integral, N m.
      limit: largest torque, N m.
    """

    proportional: Float[Array, "J"]
    integral: Float[Array, "J"]
    derivative: Float[Array, "J"]
    windup: Float[Array, "J"]
    limit: Float[Array, "J"]


class Pid(struct.PyTreeNode):
    """What the PIDs of J joints remember.

    Attributes:
      integral: torque that the integral has come to, N m.
      error: last error of the rate, rad/s.
    """

    integral: Float[Array, "J"]
    error: Float[Array, "J"]


class Effort(struct.PyTreeNode):
    """Torques that J joints are given for a while.

    Attributes:
      torque: N m.
      ticks: for how many more.
    """

    torque: Float[Array, "J"]
    ticks: Int[Array, "J"]


class Drives(struct.PyTreeNode):
    """What one walker's drives remember.

    Attributes:
      pid, effort: of every joint that has an actuator, in the actuators' order.
      retracted: the swing foot has had its retraction in this footstep.
    """

    pid: Pid
    effort: Effort
    retracted: Bool[Array, ""]


def step(gains: Gains, pid: Pid, error: Float[Array, "J"], timestep: float) -> tuple[Pid, Float[Array, "J"]]:
    """One tick of the PIDs: their memory and torques, N m, given the errors of the rates, rad/s.

    Against windup the integral's torque is bounded, and does not grow while the whole is beyond the
    joint's limit and the error would drive it further.
    """
    bounded = jnp.clip(pid.integral + gains.integral * error * timestep, -gains.windup, gains.windup)
    rest = gains.proportional * error + gains.derivative * (error - pid.error) / timestep
    saturating = (jnp.abs(rest + bounded) > gains.limit) & ((rest + bounded) * error > 0)
    integral = jnp.where(saturating, pid.integral, bounded)
    return Pid(integral, error), jnp.clip(rest + integral, -gains.limit, gains.limit)


def begin(
    effort: Effort, joints: Bool[Array, "J"], torque: Float[Array, "J"], ticks: Int[Array, ""]
) -> Effort:
    """``torque`` N m for ``ticks`` from the coming tick on, at ``joints``, in place of what they had."""
    return Effort(jnp.where(joints, torque, effort.torque), jnp.where(joints, ticks, effort.ticks))


def spend(effort: Effort) -> tuple[Effort, Float[Array, "J"]]:
    """What is left after the coming tick, and the torques in it, N m."""
    torque = jnp.where(effort.ticks > 0, effort.torque, 0.0)
    return effort.replace(ticks=jnp.maximum(effort.ticks - 1, 0)), torque


def start(where: Layout) -> Drives:
    """Drives that have done nothing yet."""
    none = where.control(jnp.zeros(6))
    return Drives(Pid(none, none), Effort(none, jnp.zeros(none.shape, jnp.int32)), jnp.bool_(True))


def gains(config: PhysicsConfig, where: Layout, body: Similarity) -> Gains:
    """The gains of the PIDs of ``body``'s joints."""
    own = config.gazebo
    pids = [own.hip, own.knee, own.ankle] * 2
    limits = [config.hip_limit, config.knee_limit, config.ankle_limit] * 2
    if where.held is not None:
        pids, limits = pids + [own.abduction] * 2, limits + [config.abduction_limit] * 2
    dimension = {
        "proportional": body.rotational_damping,
        "integral": body.torque,
        "derivative": body.inertia,
        "windup": body.torque,
    }
    named = {
        f.name: jnp.array([getattr(pid, f.name) for pid in pids]) * dimension[f.name]
        for f in dataclasses.fields(PidConfig)
    }
    return Gains(**named, limit=jnp.array(limits) * body.torque)


def rates(
    config: PhysicsConfig, where: Layout, body: Similarity, command: Float[Array, "6"], plant: Plant
) -> Float[Array, "J"]:
    """What the PIDs aim at, rad/s.

    The hip's is the command. The knee's is in proportion to how far it is off the angle commanded; the
    other joints are told to stand still.
    """
    own = config.gazebo
    hip, knee, _ = command.reshape(2, 3).T
    off = knee - where.sagittal(plant.qpos)[:, 1]
    fast = own.knee_rate_max * body.rate
    knee_rate = jnp.clip(own.knee_position_gain * body.rate * off, -fast, fast)
    return where.control(jnp.stack([hip, knee_rate, jnp.zeros(2)], axis=1).reshape(6))


def ankle_efforts(
    config: PhysicsConfig,
    where: Layout,
    body: Similarity,
    numbers: GaitConfig,
    gait: StepClock,
    foot: Float[Array, ""],
    drives: Drives,
    command: Float[Array, "6"],
    plant: Plant,
) -> Drives:
    """The efforts that the ankles begin in the coming tick.

    At touch-down the trailing ankle is pushed for the time of toe-off, no further than
    ``toe_off_ankle``. When that is over it is retracted: an effort that brings the foot to
    ``swing_ankle`` as it comes to rest against the passive damping c, whose integral is by momentum
    c (target - angle) - J rate. For the rest of the step it is passive. So is the stance ankle,
    but for the torque that the controllers command there, which is given tick by tick.

    Args:
      foot: J, its inertia about the ankle, kg m^2.
    """
    joints = jnp.zeros(drives.effort.ticks.shape, bool)
    swing = joints.at[_ANKLES].set(~gait.is_stance)
    stance = joints.at[_ANKLES].set(gait.is_stance)
    angle, rate = where.actuated(plant.qpos), where.actuated(plant.qvel)
    landed = gait.elapsed == 0

    pushed = jnp.where(swing, -gait.toe_off, 0.0)
    ticks = jnp.round(gait.toe_off_seconds / config.timestep).astype(jnp.int32)
    effort = begin(drives.effort, (swing | stance) & landed, pushed, ticks)
    commanded = where.control(command)
    effort = begin(effort, stance & (commanded != 0), commanded, jnp.int32(1))

    stopped = swing & (effort.torque < 0) & (angle < -numbers.toe_off_ankle)
    effort = effort.replace(ticks=jnp.where(stopped, 0, effort.ticks))
    retracted = drives.retracted & ~landed
    due = swing & (effort.ticks == 0) & ~retracted
    damping = config.ankle_damping * body.rotational_damping
    seconds = config.gazebo.retraction_seconds * body.time
    back = (damping * (numbers.swing_ankle - angle) - foot * rate) / seconds
    effort = begin(effort, due, back, jnp.round(seconds / config.timestep).astype(jnp.int32))
    return drives.replace(effort=effort, retracted=retracted | jnp.any(due))


def tick(
    config: PhysicsConfig,
    where: Layout,
    body: Similarity,
    numbers: GaitConfig,
    gait: StepClock,
    foot: Float[Array, ""],
    drives: Drives,
    command: Float[Array, "6"],
    plant: Plant,
) -> tuple[Drives, Float[Array, "J"]]:
    """The drives after the coming tick, and the torque of each actuator in it, N m.

    Args:
      command: [6] hip rate (rad/s), knee angle (rad), ankle torque (N m); left, then right.
      foot: as for `ankle_efforts`.
    """
    begun = ankle_efforts(config, where, body, numbers, gait, foot, drives, command, plant)
    effort, given = spend(begun.effort)
    error = rates(config, where, body, command, plant) - where.actuated(plant.qvel)
    pid, torque = step(gains(config, where, body), begun.pid, error, config.timestep)
    return begun.replace(pid=pid, effort=effort), torque + given
