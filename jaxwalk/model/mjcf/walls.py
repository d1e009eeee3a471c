"""The paper's own walker: free in space, between two frictionless walls that let it tilt a little.

The root has all six degrees of freedom. They are three slides and three hinges, not a free joint, so
that pitch and forward speed are coordinates, as in the plane; the pitch comes first, about the world's
axis, and roll and yaw, which could make that singular at 90 degrees, stay within the walls.
Hip y of the paper is ``abduction``, its ankle y ``inversion``.
"""

from __future__ import annotations

import mujoco

from jaxwalk.config import PhysicsConfig
from jaxwalk.model.anthropometry import HIP_TO_SHOULDER, Body
from jaxwalk.model.mjcf import parts
from jaxwalk.model.mjcf.layout import SIDES, WALLS
from jaxwalk.model.similarity import Similarity

GAP = 0.01 / 1.8  # fraction of height, between the trunk in the middle and each wall
# m of that, in which a wall gives way: MuJoCo's contacts are soft. How soft does not go with the stature.
LINING = 0.002
_RADIUS = 0.005  # fraction of height, of what touches the walls
REACH = parts.TRUNK_DEPTH - _RADIUS  # fraction of height: of the hip's points, ahead and behind
BREADTH = parts.TRUNK_BREADTH - _RADIUS  # fraction of height: of the points' centres, left and right
SHOULDER = HIP_TO_SHOULDER  # fraction of height, over the hip
_AXES = ("SLIDE x", "SLIDE z", "HINGE y", "SLIDE y", "HINGE x", "HINGE z")


def build(body: Body, physics: PhysicsConfig) -> mujoco.MjSpec:
    """The walker of ``body`` between walls: 16 degrees of freedom, 8 actuators.

    Contacts: four corners of each sole with the floor; with each wall, frictionless, the trunk's
    side along the hip (front and back) and at the shoulder.
    Actuators: those of the planar walker, then one that holds each hip's abduction still. Sensors:
    those of the planar walker, then the force on each wall, left and right.
    """
    scale = Similarity.of(body.height, body.mass)
    spec = parts.scene("jaxwalk walker between walls", physics)
    torso = spec.worldbody.add_body(name="torso", pos=[0, 0, 0])
    depth, breadth = parts.TRUNK_DEPTH * body.height, parts.TRUNK_BREADTH * body.height
    parts.inertial(torso, body.torso, (depth, breadth, body.torso.length / 2))
    for name, joint in zip(WALLS.root, _AXES, strict=True):
        kind, axis = joint.split()
        axes = [float(axis == each) for each in "xyz"]
        torso.add_joint(name=name, type=getattr(mujoco.mjtJoint, f"mjJNT_{kind}"), axis=axes)
    parts.trunk(torso, body)
    for side in SIDES:
        parts.leg(spec, torso, side, body, scale, physics, spatial=True)
        parts.servos(spec, side, scale, physics)
    for side in SIDES:
        _hold(spec, side, scale, physics)
        _wall(spec, torso, side, body, physics)
    parts.instruments(spec)
    for side in SIDES:
        parts.sensor(spec, f"wall_{side}", "TOUCH", f"flank_{side}")
    return spec


def _hold(spec: mujoco.MjSpec, side: str, scale: Similarity, physics: PhysicsConfig) -> None:
    """The velocity PID of hip y, told to stand still: the integral of its rate's error is its angle."""
    if physics.drives == "gazebo":
        parts.effort(spec, f"abduction_{side}", physics.abduction_limit * scale.torque)
        return
    proportional = physics.abduction_gain * scale.rotational_damping
    integral = physics.abduction_integral * scale.torque
    limit = physics.abduction_limit * scale.torque
    parts.actuator(spec, f"abduction_{side}", limit, integral, (-integral, -proportional))


def _wall(spec: mujoco.MjSpec, torso: mujoco.MjsBody, side: str, body: Body, physics: PhysicsConfig) -> None:
    """A wall, what of the trunk touches it, and the site that feels it."""
    left = 1.0 if side == "left" else -1.0
    breadth = parts.TRUNK_BREADTH * body.height
    radius, shoulder = _RADIUS * body.height, SHOULDER * body.height
    spec.worldbody.add_geom(
        name=f"wall_{side}",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        pos=[0, left * (breadth + GAP * body.height), 0],
        zaxis=[0, -left, 0],
        size=[0, 0, 1],
        contype=0,
        conaffinity=0,
        group=parts.COLLIDES,
    )
    y, reach = left * BREADTH * body.height, REACH * body.height
    torso.add_geom(
        name=f"hip_{side}",
        type=mujoco.mjtGeom.mjGEOM_CAPSULE,
        fromto=[-reach, y, 0, reach, y, 0],
        size=[radius, 0, 0],
        contype=0,
        conaffinity=0,
        group=parts.COLLIDES,
        mass=0,
        rgba=[0.3, 0.3, 0.3, 0.3],
    )
    parts.ball(torso, f"shoulder_{side}", (0.0, y, shoulder), radius)
    for name in (f"hip_{side}", f"shoulder_{side}"):
        spec.add_pair(
            name=name,
            geomname1=f"wall_{side}",
            geomname2=name,
            condim=1,
            margin=LINING,
            solref=[physics.contact_timeconst, 1.0],
        )
    torso.add_site(
        name=f"flank_{side}",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=[0, left * breadth, shoulder / 2],
        size=[2 * reach, breadth / 2, body.torso.length],
        rgba=[0, 0, 0, 0],
    )
