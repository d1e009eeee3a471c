"""The plant in C MuJoCo, solved to convergence: a second opinion on what MJX makes of a walker.

The same closed loop calls it back from within the compiled program, once a tick for a whole batch
(under ``vmap``), so that nothing but the plant changes. It keeps nothing from tick to tick: `Plant`
holds all that the next one needs, rounded to float32 as MJX has it; within a tick C computes in doubles.
"""

from __future__ import annotations

import dataclasses
from functools import lru_cache, partial
from typing import Any

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from jaxtyping import Array, Float

from jaxwalk.config import REFERENCE_HEIGHT, REFERENCE_MASS, BodyConfig, PhysicsConfig
from jaxwalk.model import burdens
from jaxwalk.model import physics as mjx_physics
from jaxwalk.model.burdens import Burden
from jaxwalk.model.physics import Plant, Readings
from jaxwalk.model.similarity import Similarity

_BODIES = 1024  # compiled models that are kept, of some 0.2 MB each
_STATE: Any = mujoco.mjtState
_OUTPUT = int(_STATE.mjSTATE_QPOS | _STATE.mjSTATE_QVEL | _STATE.mjSTATE_WARMSTART)
_INPUT = _OUTPUT | int(_STATE.mjSTATE_CTRL | _STATE.mjSTATE_XFRC_APPLIED)  # in this order


def converged(physics: PhysicsConfig) -> PhysicsConfig:
    """The same physics with the solver run to convergence."""
    return dataclasses.replace(physics, iterations=100, ls_iterations=50, tolerance=1e-10)


def step(
    config: BodyConfig,
    physics: PhysicsConfig,
    body: Similarity,
    plant: Plant,
    control: Float[Array, "A"],
    push: Float[Array, "7 2"],
    burden: Burden | None = None,
) -> tuple[Plant, Readings]:
    """One tick, as `jaxwalk.model.physics.step` makes it.

    Args:
      config: the table of the body; its height and mass are ``body``'s.
      physics: its solver settings are not used, see `converged`.
      control, push: as for it.
      burden: its pack and floor; its force is part of ``push``.

    Returns:
      The plant after the tick, and what was sensed; NaN throughout for a plant that is not finite.
    """
    where = mjx_physics.layout(config)
    plain = jax.ShapeDtypeStruct((where.dofs,), jnp.float32)
    qpos, qvel, warmstart, sensed = jax.pure_callback(
        partial(_batch, config, physics),
        (plain, plain, plain, jax.ShapeDtypeStruct((where.sensed,), jnp.float32)),
        sizes(body, burden),
        plant.qpos,
        plant.qvel,
        plant.warmstart,
        control,
        push,
        vmap_method="broadcast_all",
    )
    return Plant(qpos, qvel, warmstart), mjx_physics.readings_of(where, sensed, qpos, qvel)


def sizes(body: Similarity, burden: Burden | None) -> Float[Array, "S"]:
    """[S] what `compiled` is to be told of one walker: ratios of length and mass, and its burden if any."""
    borne = () if burden is None else (burden.mass, burden.ahead, burden.up, burden.friction)
    return jnp.stack([jnp.float32(x) for x in (body.length, body.mass, *borne)])


@lru_cache(maxsize=_BODIES)
def compiled(
    config: BodyConfig, physics: PhysicsConfig, length: float, mass: float, *borne: float
) -> mujoco.MjModel:
    """The model of one walker of the table of ``config``.

    Args:
      length, mass, borne: its `sizes`.
    """
    body = dataclasses.replace(config, height=length * REFERENCE_HEIGHT, mass=mass * REFERENCE_MASS)
    model = mjx_physics.compile_mujoco(body, converged(physics))
    # A state that blows up is told as it is (a fall), not put back to the start.
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    if borne:
        _put_onto(model, *borne)
    return model


def _put_onto(model: mujoco.MjModel, pack: float, ahead: float, up: float, friction: float) -> None:
    """Change ``model`` in place as `burdens.onto` does MJX's."""
    burden = Burden(pack, ahead, up, 0.0, friction)
    own = model.body_inertia[1, 1]
    _, (forth, higher), inertia = burdens.laden(model.body_mass[1], own, burden)
    model.body_mass[1] += pack
    model.body_subtreemass[:2] += pack
    model.body_ipos[1] += [forth, 0.0, higher]
    model.body_inertia[1] *= inertia / own
    model.pair_friction[:, :2] = friction


def _batch(
    config: BodyConfig,
    physics: PhysicsConfig,
    bodies: Array,
    qpos: Array,
    qvel: Array,
    warmstart: Array,
    control: Array,
    push: Array,
) -> tuple[np.ndarray, ...]:
    """[..., n] arrays of any leading shape; gives qpos, qvel, warmstart and sensors, float32 as they came."""
    lead = qpos.shape[:-1]
    told = [np.asarray(x, np.float64).reshape(-1, x.shape[-1]) for x in (qpos, qvel, warmstart, control)]
    told_of = [tuple(row) for row in np.asarray(bodies, np.float64).reshape(-1, bodies.shape[-1]).tolist()]
    known = {size: compiled(config, physics, *size) for size in set(told_of)}
    models = [known[size] for size in told_of]
    wrench = np.zeros((len(models), models[0].nbody, 6))
    wrench[:, 1:, [0, 4]] = np.asarray(push).reshape(len(models), -1, 2)
    before = np.concatenate([*told, wrench.reshape(len(models), -1)], axis=1)
    after = np.full((len(models), 3 * qpos.shape[-1]), np.nan)
    sensed = np.full((len(models), models[0].nsensordata), np.nan)
    data = mujoco.MjData(models[0])  # bodies differ in sizes, not in what there is of them
    for row in np.flatnonzero(np.isfinite(before).all(1)):
        mujoco.mj_setState(models[row], data, before[row], _INPUT)
        mujoco.mj_step(models[row], data)
        mujoco.mj_getState(models[row], data, after[row], _OUTPUT)
        sensed[row] = data.sensordata
    return tuple(np.float32(x).reshape(*lead, -1) for x in (*np.split(after, 3, axis=1), sensed))
