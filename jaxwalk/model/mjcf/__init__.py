"""The walker as MJCF, built with ``mujoco.MjSpec``: in the plane, or between two walls.

Conventions: x forward, y to the left, z up. The root is at the hip, so that ``qpos[:3]`` is hip x,
hip height, torso pitch (positive leans forward) in both. Joint angles: hip flexion, knee flexion and
ankle dorsiflexion are positive, and so are hip abduction and foot inversion where there are such.
"""

import mujoco

from jaxwalk.config import BodyModel, PhysicsConfig
from jaxwalk.model.anthropometry import Body
from jaxwalk.model.mjcf import planar, walls
from jaxwalk.model.mjcf.layout import LAYOUTS, PLANAR, SEGMENTS, SIDES, WALLS, Layout
from jaxwalk.model.mjcf.parts import COLLIDES, DRAWN

__all__ = ["COLLIDES", "DRAWN", "LAYOUTS", "PLANAR", "SEGMENTS", "SIDES", "WALLS", "Layout", "build"]

_BUILDERS = {"planar": planar.build, "walls": walls.build}


def build(body: Body, physics: PhysicsConfig, model: BodyModel = "planar") -> mujoco.MjSpec:
    """The walker of ``body``, as ``model`` says."""
    return _BUILDERS[model](body, physics)
