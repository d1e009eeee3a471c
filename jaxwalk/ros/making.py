"""The body's file out of a configuration: the one part of this package that computes with JAX."""

from __future__ import annotations

import dataclasses

import jax
import numpy as np

from jaxwalk.common.errors import UserError
from jaxwalk.config import Config
from jaxwalk.model import c_mujoco, ode, physics
from jaxwalk.model.mjcf import LAYOUTS, SEGMENTS
from jaxwalk.ros.body import Body
from jaxwalk.task import deployed, scenarios


def body(config: Config, seed: int) -> Body:
    """The walker of ``config``, at a start of `jaxwalk.control.walker.start`.

    Raises:
      UserError: it is not planar, or its legs do not speak torques.
    """
    ode.check(config.body)
    if config.gait.form != "compliant":
        raise UserError("jaxwalk ros: joints are told torques: give a policy of legs that yield, as shipped")
    begun = jax.device_get(deployed.start(config, scenarios.root(seed, scenarios.DEPLOYED)).replace(key=None))
    moved_by = c_mujoco.converged(dataclasses.replace(config.physics, drives="torque"))
    tree = ode.tree(physics.compile_mujoco(config.body, moved_by))
    names = LAYOUTS[config.body.model].joints
    return Body(
        tree=tree,
        qpos=np.asarray(begun.plant.qpos, np.float64),
        qvel=np.asarray(begun.plant.qvel, np.float64),
        touch=np.asarray(begun.estimate.touch, np.float64),
        stance=int(begun.gait.stance),
        segments=SEGMENTS,
        joints=tuple(names[2 + driven] for driven in tree.driven),
    )
