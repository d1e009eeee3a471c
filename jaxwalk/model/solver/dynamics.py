"""One step of MJX's own dynamics, but for the equations that it solves.

Kinematics, collisions, constraint rows, actuators and sensors are MJX's. Its solver and its integrator call
LAPACK for every walker and try step lengths one after another; here `newton` and `spd` take their places,
which solve the same equations for a batch at a time.
"""

from __future__ import annotations

import jax
import mujoco
import numpy as np
from mujoco import mjx

from jaxwalk.common.errors import UserError
from jaxwalk.model.solver import newton, spd


def check(model: mujoco.MjModel) -> None:
    """See that `step` holds for ``model``.

    Raises:
      UserError: what it does not hold for, by name.
    """
    joints = {int(mujoco.mjtJoint.mjJNT_SLIDE), int(mujoco.mjtJoint.mjJNT_HINGE)}
    servos = {int(mujoco.mjtBias.mjBIAS_NONE), int(mujoco.mjtBias.mjBIAS_AFFINE)}
    options = model.opt
    found = [
        what
        for what, there in (
            ("joints that neither slide nor turn about one axis", not set(model.jnt_type.tolist()) <= joints),
            ("springs of joints or tendons", model.ntendon > 0 or bool(np.any(model.jnt_stiffness))),
            ("equality constraints", model.neq > 0),
            ("dry friction of joints", bool(np.any(model.dof_frictionloss))),
            ("elliptic friction cones", options.cone != mujoco.mjtCone.mjCONE_PYRAMIDAL),
            ("a sparse Jacobian", options.jacobian != mujoco.mjtJacobian.mjJAC_DENSE),
            (
                "another integrator than implicitfast",
                options.integrator != mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
            ),
            ("actuators with a state of their own", model.na > 0),
            ("actuators other than motors and servos", not set(model.actuator_biastype.tolist()) <= servos),
            ("a fluid", options.density > 0 or options.viscosity > 0),
        )
        if there
    ]
    if found:
        raise UserError(f"the body's model has {', '.join(found)}: give --physics.solver mjx")


def step(model: mjx.Model, data: mjx.Data, iterations: int) -> mjx.Data:
    """What ``mjx.step`` does, for models of slides and hinges with pyramidal contacts, a dense Jacobian, and
    ``implicitfast``.

    Args:
      iterations: of Newton's method.
    """
    # A GPU would round what it multiplies to ten bits.
    with jax.default_matmul_precision("highest"):
        return _step(model, data, iterations)


def _step(model: mjx.Model, data: mjx.Data, iterations: int) -> mjx.Data:
    data = mjx.sensor_pos(model, mjx.fwd_position(model, data))
    data = mjx.sensor_vel(model, mjx.fwd_velocity(model, data))
    data = _accelerated(model, mjx.fwd_actuation(model, data))
    data = mjx.sensor_acc(model, _constrained(data, iterations))
    return _integrated(model, data)


def _accelerated(model: mjx.Model, data: mjx.Data) -> mjx.Data:
    """``data`` with the acceleration that there would be without constraints."""
    applied = data.qfrc_applied + mjx.xfrc_accumulate(model, data)
    force = data.qfrc_passive - data.qfrc_bias + data.qfrc_actuator + applied
    return data.replace(qfrc_smooth=force, qacc_smooth=spd.solve_one(data._impl.M, force))


def _constrained(data: mjx.Data, iterations: int) -> mjx.Data:
    known = data._impl
    problem = newton.Problem(known.M, data.qacc_smooth, known.efc_J, known.efc_D, known.efc_aref)
    acceleration, forces = newton.minimize(problem, data.qacc_warmstart, iterations)
    return data.tree_replace(
        {"qacc": acceleration, "qfrc_constraint": known.efc_J.T @ forces, "_impl.efc_force": forces}
    )


def _integrated(model: mjx.Model, data: mjx.Data) -> mjx.Data:
    """``implicitfast``: forces that depend on velocity are taken as they will be at the step's end."""
    seconds = model.opt.timestep
    inertia = data._impl.M - seconds * mjx.deriv_smooth_vel(model, data)
    acceleration = spd.solve_one(inertia, data.qfrc_smooth + data.qfrc_constraint)
    qvel = data.qvel + seconds * acceleration
    return data.replace(
        qvel=qvel,
        qpos=data.qpos + seconds * qvel,
        qacc_warmstart=data.qacc,
        time=data.time + seconds,
    )
