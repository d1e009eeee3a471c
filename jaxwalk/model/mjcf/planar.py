"""The walker in the plane: a root that slides and pitches, feet on heel and toe."""

from __future__ import annotations

import mujoco

from jaxwalk.config import PhysicsConfig
from jaxwalk.model.anthropometry import Body
from jaxwalk.model.mjcf import parts
from jaxwalk.model.mjcf.layout import PLANAR, SIDES
from jaxwalk.model.similarity import Similarity


def build(body: Body, physics: PhysicsConfig) -> mujoco.MjSpec:
    """The planar walker of ``body``: 9 degrees of freedom, 4 foot contacts, 6 actuators.

    Actuators, three a side: hip velocity servo (rad/s), knee position servo
    (rad), ankle effort (N m), left then right. Sensors: IMU at the torso's centre of
    mass (velocity, up axis, gyro) and a touch sensor under each foot.
    """
    scale = Similarity.of(body.height, body.mass)
    spec = parts.scene("jaxwalk planar walker", physics)
    torso = spec.worldbody.add_body(name="torso", pos=[0, 0, 0])
    parts.inertial(torso, body.torso)
    for name, kind, axis in zip(
        PLANAR.root, ("SLIDE", "SLIDE", "HINGE"), ([1, 0, 0], [0, 0, 1], [0, 1, 0]), strict=True
    ):
        torso.add_joint(name=name, type=getattr(mujoco.mjtJoint, f"mjJNT_{kind}"), axis=axis)
    parts.trunk(torso, body)
    for side in SIDES:
        parts.leg(spec, torso, side, body, scale, physics, spatial=False)
        parts.servos(spec, side, scale, physics)
    parts.instruments(spec)
    return spec
