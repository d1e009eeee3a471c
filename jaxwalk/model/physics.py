"""The plant: one walker's rigid body in MJX, one tick at a time.

Of ``mjx.Data`` only what a tick hands to the next is carried: position, velocity and
the solver's warm start. Everything else is rebuilt from a constant template.
"""

from __future__ import annotations

from functools import lru_cache, partial
from typing import Any, TypeVar

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from flax import struct
from jaxtyping import Array, Float
from mujoco import mjx

from jaxwalk.config import BodyConfig, PhysicsConfig
from jaxwalk.model import anthropometry, mjcf
from jaxwalk.model.mjcf import Layout
from jaxwalk.model.similarity import Similarity
from jaxwalk.model.solver import dynamics

T = TypeVar("T")

# (h exponent, m exponent) of every model leaf that a body changes. Checked against a
# compiled model in the tests.
_LEAVES = {
    "body_pos": (1, 0),
    "body_ipos": (1, 0),
    "body_mass": (0, 1),
    "body_subtreemass": (0, 1),
    "body_inertia": (2, 1),
    "geom_pos": (1, 0),
    "geom_rbound": (1, 0),
    "site_pos": (1, 0),
    "dof_damping": (1.5, 1),
    "actuator_forcerange": (1, 1),
}


class Plant(struct.PyTreeNode):
    """What one tick hands to the next.

    Attributes:
      qpos: [D] hip x, hip height (m), torso pitch (rad), then the other joints as `layout` has them
        (m, rad); D is 9 in the plane, 16 between walls.
      qvel: [D] their rates.
      warmstart: [D] the solver's last acceleration.
    """

    qpos: Float[Array, "D"]
    qvel: Float[Array, "D"]
    warmstart: Float[Array, "D"]


class Readings(struct.PyTreeNode):
    """Noise-free instruments of the tick just made.

    Attributes:
      velocity: [3] of the IMU, world frame, m/s.
      up: [3] the torso's long axis, world frame.
      gyro: [3] angular velocity in the torso's frame, rad/s.
      touch: [2] normal force under the left and right sole, N.
      joints, joint_rates: [2, 3] hip, knee, ankle of each leg, rad and rad/s.
      walls: [2] normal force of the left and the right wall, N; None in the plane.
    """

    velocity: Float[Array, "3"]
    up: Float[Array, "3"]
    gyro: Float[Array, "3"]
    touch: Float[Array, "2"]
    joints: Float[Array, "2 3"]
    joint_rates: Float[Array, "2 3"]
    walls: Float[Array, "2"] | None = None


def layout(body: BodyConfig) -> Layout:
    """Where the joints of ``body``'s model lie."""
    return mjcf.LAYOUTS[body.model]


def compile_mujoco(body: BodyConfig, physics: PhysicsConfig) -> mujoco.MjModel:
    """The walker as a C MuJoCo model."""
    return mjcf.build(anthropometry.build(body), physics, body.model).compile()


@lru_cache(maxsize=16)
def _reference_on_host(body: BodyConfig, physics: PhysicsConfig) -> mjx.Model:
    with jax.ensure_compile_time_eval():
        compiled = compile_mujoco(body, physics)
        if physics.solver == "own":
            dynamics.check(compiled)
        model = mjx.put_model(compiled, _own_device(), impl="jax")
        return jax.tree.map(np.asarray, model)


@lru_cache(maxsize=16)
def _template_on_host(body: BodyConfig, physics: PhysicsConfig) -> mjx.Data:
    with jax.ensure_compile_time_eval():
        return jax.tree.map(np.asarray, mjx.make_data(_reference(body, physics), _own_device(), impl="jax"))


def _own_device() -> jax.Device:  # pyright: ignore[reportInvalidTypeForm]  # a class, which JAX's stub hides
    """A device that this process can read: MJX would take the first of all processes."""
    return jax.local_devices()[0]


def _constants(tree: T) -> T:
    """``tree`` as this program's own arrays: one that is kept would belong to the mesh it was made under."""
    with jax.ensure_compile_time_eval():
        return jax.tree.map(jnp.asarray, tree)


def _reference(body: BodyConfig, physics: PhysicsConfig) -> mjx.Model:
    return _constants(_reference_on_host(body, physics))


def model_of(config: BodyConfig, physics: PhysicsConfig, body: Similarity) -> mjx.Model:
    """The model of a body of the configured table but its own height and mass.

    ``body`` may hold traced scalars, so walkers of one batch may differ without
    recompiling. Inverse weights and servo gains scale along (see ``similarity``).
    """
    model = _reference(config, physics)
    base = Similarity.of(config.height, config.mass)
    h, m = body.length / base.length, body.mass / base.mass
    leaves = {name: getattr(model, name) * jnp.float32(h**p * m**q) for name, (p, q) in _LEAVES.items()}
    translational, rotational = 1 / m, 1 / (m * h**2)
    weights = jnp.stack([jnp.float32(translational), jnp.float32(rotational)])
    dof = jnp.where(model.jnt_type == int(mujoco.mjtJoint.mjJNT_SLIDE), weights[0], weights[1])
    damping, stiffness = m * h**1.5, m * h
    position = jnp.asarray(model.actuator_biastype == int(mujoco.mjtBias.mjBIAS_AFFINE)) & (
        model.actuator_gainprm[:, 0] == -model.actuator_biasprm[:, 1]
    )
    velocity = jnp.asarray(model.actuator_biastype == int(mujoco.mjtBias.mjBIAS_AFFINE)) & ~position
    gain = jnp.where(velocity, damping, jnp.where(position, stiffness, 1.0))
    bias = model.actuator_biasprm
    bias = bias.at[:, 1].multiply(stiffness).at[:, 2].multiply(damping)
    plane = jnp.asarray(model.geom_type == int(mujoco.mjtGeom.mjGEOM_PLANE))  # floor and walls have no size
    return model.replace(
        **leaves,
        geom_size=model.geom_size * jnp.where(plane, 1.0, h)[:, None],
        body_invweight0=model.body_invweight0 * weights,
        dof_invweight0=model.dof_invweight0 * dof,
        actuator_gainprm=model.actuator_gainprm * gain[:, None],
        actuator_biasprm=bias,
    )


def _saturated(where: Layout, model: mjx.Model, plant: Plant, control: Float[Array, "A"]) -> mjx.Model:
    """Servos at their limit become constant torques.

    C MuJoCo does so within ``implicitfast``: a clamped force has no derivative. MJX keeps
    the derivative, which brakes a saturated hip like 0.6 kg m^2 of inertia would.
    """
    gain, bias = model.actuator_gainprm, model.actuator_biasprm
    angle, rate = where.actuated(plant.qpos), where.actuated(plant.qvel)
    force = gain[:, 0] * control + bias[:, 0] + bias[:, 1] * angle + bias[:, 2] * rate
    low, high = model.actuator_forcerange[:, 0], model.actuator_forcerange[:, 1]
    # A pure effort has no derivative to lose, and no bias to hold the limit.
    servo = jnp.asarray(model.actuator_biastype == int(mujoco.mjtBias.mjBIAS_AFFINE))
    clamped = (servo & ((force < low) | (force > high)))[:, None]
    constant = jnp.zeros_like(bias).at[:, 0].set(jnp.clip(force, low, high))
    return model.replace(
        actuator_gainprm=jnp.where(clamped, 0.0, gain), actuator_biasprm=jnp.where(clamped, constant, bias)
    )


def readings_of(
    where: Layout, sensed: Float[Array, "S"], qpos: Float[Array, "D"], qvel: Float[Array, "D"]
) -> Readings:
    """A tick's readings: MuJoCo's sensors, those of its start; joints after it, as encoders are read."""
    return Readings(
        velocity=sensed[0:3],
        up=sensed[3:6],
        gyro=sensed[6:9],
        touch=sensed[9:11],
        joints=where.sagittal(qpos),
        joint_rates=where.sagittal(qvel),
        walls=sensed[11:13] if where.walls else None,
    )


def advance(
    config: BodyConfig,
    physics: PhysicsConfig,
    model: mjx.Model,
    plant: Plant,
    control: Float[Array, "A"],
    push: Float[Array, "7 2"],
) -> tuple[mjx.Model, mjx.Data]:
    """One tick, with all that MJX knows of it.

    Args:
      control, push: as for `step`.

    Returns:
      The model that the tick was made with (`_saturated`), and the data after it: positions and
      velocities are those of the tick's end, forces and sensors those of its start.
    """
    data = _constants(_template_on_host(config, physics))
    model = _saturated(layout(config), model, plant, control)
    nought = jnp.zeros(len(mjcf.SEGMENTS))
    wrench = jnp.stack([push[:, 0], nought, nought, nought, push[:, 1], nought], axis=1)
    data = data.replace(
        qpos=plant.qpos,
        qvel=plant.qvel,
        qacc_warmstart=plant.warmstart,
        ctrl=control,
        xfrc_applied=jnp.concatenate([jnp.zeros((1, 6)), wrench]),  # nobody pushes the world
    )
    if physics.solver == "mjx":
        return model, mjx.step(model, data)
    return model, dynamics.step(model, data, physics.iterations)


def outcome(config: BodyConfig, data: mjx.Data) -> tuple[Plant, Readings]:
    """What the tick that `advance` made hands on, and what was sensed of it."""
    readings = readings_of(layout(config), data.sensordata, data.qpos, data.qvel)
    return Plant(data.qpos, data.qvel, data.qacc_warmstart), readings


def step(
    config: BodyConfig,
    physics: PhysicsConfig,
    model: mjx.Model,
    plant: Plant,
    control: Float[Array, "A"],
    push: Float[Array, "7 2"],
) -> tuple[Plant, Readings]:
    """One tick.

    Args:
      control: [A] of each actuator. Servos: hip rate (rad/s), knee angle (rad), ankle torque (N m); left,
        then right, then what the layout has beyond (see `Layout.control`). Gazebo's drives: torques, N m.
      push: [7, 2] forward force (N) and pitching moment (N m) at each segment's centre of mass.
    """
    return _step(config, physics, model, plant, control, push)


# Traced once for all programs of a process: MJX's own Python takes seconds.
@partial(jax.jit, static_argnums=(0, 1), inline=True)
def _step(config: BodyConfig, physics: PhysicsConfig, *moving: Any) -> tuple[Plant, Readings]:
    _, data = advance(config, physics, *moving)
    return outcome(config, data)
