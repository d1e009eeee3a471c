"""The plant in ODE, the engine of the paper's GAZEBO: called back from within the same closed loop.

As in `jaxwalk.model.c_mujoco` nothing but the plant changes, and nothing is kept from tick to tick but
`Plant`. Bodies, joints and actuators are those of the compiled MJCF, so that there is one body; contacts
are softened as MuJoCo's are (`_softness`).
"""

from __future__ import annotations

import threading
from functools import lru_cache, partial
from typing import Any

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from jaxtyping import Array, Float

from jaxwalk.common.errors import UserError
from jaxwalk.config import BodyConfig, PhysicsConfig
from jaxwalk.model import c_mujoco
from jaxwalk.model import physics as mjx_physics
from jaxwalk.model.burdens import Burden
from jaxwalk.model.mjcf import SEGMENTS, SIDES
from jaxwalk.model.physics import Plant, Readings
from jaxwalk.model.similarity import Similarity
from jaxwalk.ode import Method, Tree, World, library

_WORLDS = 1024  # that are kept
_PRESSED = 0.002  # m: MuJoCo's contacts are as hard as they become from 1 mm on
_ONE_AT_A_TIME = threading.Lock()  # worlds are no two threads' at once


def check(config: BodyConfig) -> None:
    """That ODE can move the body of ``config`` here.

    Raises:
      UserError: there is no ODE, or it is a body that is not planar.
    """
    if config.model != "planar":
        raise UserError(
            f"--engine ode: moves planar walkers, not those of model {config.model}: leave it out"
        )
    library.load()


def step(
    config: BodyConfig,
    physics: PhysicsConfig,
    method: Method,
    body: Similarity,
    plant: Plant,
    control: Float[Array, "A"],
    push: Float[Array, "7 2"],
    burden: Burden | None = None,
) -> tuple[Plant, Readings]:
    """One tick, as `jaxwalk.model.c_mujoco.step` makes it, but by ODE's ``method``.

    Returns:
      The plant after the tick, its ``warmstart`` as it was: ODE has none; and what was sensed.
    """
    where = mjx_physics.layout(config)
    plain = jax.ShapeDtypeStruct((where.dofs,), jnp.float32)
    qpos, qvel, sensed = jax.pure_callback(
        partial(_batch, config, physics, method),
        (plain, plain, jax.ShapeDtypeStruct((where.sensed,), jnp.float32)),
        c_mujoco.sizes(body, burden),
        plant.qpos,
        plant.qvel,
        control,
        push,
        vmap_method="broadcast_all",
    )
    return Plant(qpos, qvel, plant.warmstart), mjx_physics.readings_of(where, sensed, qpos, qvel)


@lru_cache(maxsize=_WORLDS)
def _world(config: BodyConfig, physics: PhysicsConfig, method: Method, *sizes: float) -> World:
    return World(tree(c_mujoco.compiled(config, physics, *sizes)), method)


def _batch(
    config: BodyConfig,
    physics: PhysicsConfig,
    method: Method,
    bodies: Array,
    qpos: Array,
    qvel: Array,
    control: Array,
    push: Array,
) -> tuple[np.ndarray, ...]:
    """[..., n] arrays of any leading shape; gives qpos, qvel and sensors, float32 as they came."""
    lead = qpos.shape[:-1]
    sizes, *told = (np.asarray(x, np.float64).reshape(-1, x.shape[-1]) for x in (bodies, qpos, qvel, control))
    pushed = np.asarray(push, np.float64).reshape(len(sizes), *push.shape[-2:])
    with _ONE_AT_A_TIME:
        rows = [
            _world(config, physics, method, *size).tick(*moving)
            for size, *moving in zip(sizes.tolist(), *told, pushed, strict=True)
        ]
    return tuple(np.array(part, np.float32).reshape(*lead, -1) for part in zip(*rows, strict=True))


def tree(model: mujoco.MjModel) -> Tree:
    """What ODE is to be told of a compiled planar walker."""
    hinges = 2 + np.arange(model.nbody - 1)  # after the root's two slides, a hinge a body
    balls = [model.pair_geom2[i] for i in range(model.npair)]
    driven = model.actuator_trnid[:, 0]
    stiffness, yielding = _softness(model)
    return Tree(
        timestep=model.opt.timestep,
        gravity=-float(model.opt.gravity[2]),
        parent=model.body_parentid[1:] - 1,
        anchor=model.body_pos[1:, [0, 2]].copy(),
        centre=model.body_ipos[1:, [0, 2]].copy(),
        mass=model.body_mass[1:].copy(),
        inertia=model.body_inertia[1:, 1].copy(),
        turn=model.jnt_axis[hinges, 1].copy(),
        damping=model.dof_damping[hinges].copy(),
        imu=model.site("imu").pos[[0, 2]].copy(),
        foot=model.geom_bodyid[balls] - 1,
        ball=model.geom_pos[balls][:, [0, 2]].copy(),
        radius=model.geom_size[balls, 0].copy(),
        stiffness=stiffness,
        yielding=yielding,
        friction=float(model.pair_friction[0, 0]),
        soles=np.array([SEGMENTS.index(f"foot_{side}") for side in SIDES]),
        driven=driven - hinges[0],
        gain=model.actuator_gainprm[:, 0].copy(),
        offset=model.actuator_biasprm[:, 1].copy(),
        rate=model.actuator_biasprm[:, 2].copy(),
        limit=model.actuator_forcerange[:, 1].copy(),
    )


def _softness(model: mujoco.MjModel) -> tuple[np.ndarray, np.ndarray]:
    """Spring (N/m) and damper (N s/m), [K] each, of the balls' contacts.

    MuJoCo's contact is a + B v - K depth = -R f: acceleration and velocity along the normal, its force f. Its
    constants come from the time constant T and the impedance d (0.95 of a contact that is pressed): K =
    1 / (d T)^2, B = 2 / (d T), R = (1 - d) / d of the foot's inverse weight. Where the ball is not
    accelerated that is a spring K / R and a damper B / R, which ODE's contact is made of; the term of a,
    as if the ball weighed 1 / R more, has nothing like it in ODE.
    """
    data: Any = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    lowest = min(data.geom_xpos[ball, 2] - model.geom_size[ball, 0] for ball in model.pair_geom2)
    data.qpos[1] = -lowest - _PRESSED  # legs straight, feet flat
    mujoco.mj_forward(model, data)
    place = {int(one.geom2): int(one.efc_address) for one in data.contact}
    rows = [place[int(ball)] for ball in model.pair_geom2]
    hard, damp = data.efc_KBIP[rows, 0], data.efc_KBIP[rows, 1]
    # Of a pyramid's edges, each with a regularisation of its own, the normal has four.
    regular = data.efc_R[rows] / 4
    return hard / regular, damp / regular
