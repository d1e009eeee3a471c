"""Pieces that both models are made of."""

from __future__ import annotations

import mujoco

from jaxwalk.config import GRAVITY, PhysicsConfig
from jaxwalk.model import strength
from jaxwalk.model.anthropometry import Body, Segment
from jaxwalk.model.mjcf.layout import SIDES
from jaxwalk.model.similarity import Similarity

DRAWN, COLLIDES = 1, 3  # geom groups: boxes are drawn, spheres collide
SOLE_RADIUS = 0.01  # fraction of height
HIP_WIDTH = 0.05  # fraction of height, from the middle
LEG_WIDTH = 0.025  # fraction of height, half of the box
TRUNK_DEPTH, TRUNK_BREADTH = 0.05, 0.09  # fractions of height, halves of the box
_COLOURS = {"left": [0.20, 0.45, 0.75, 1.0], "right": [0.85, 0.45, 0.20, 1.0]}

Triple = tuple[float, float, float]


def scene(name: str, physics: PhysicsConfig) -> mujoco.MjSpec:
    """A floor, light, and how MuJoCo integrates."""
    spec = mujoco.MjSpec()
    spec.modelname = name
    spec.compiler.degree = False
    spec.option.timestep = physics.timestep
    spec.option.gravity = [0, 0, -GRAVITY]
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE  # MuJoCo 4.0.0's sparse Newton is wrong
    spec.option.cone = mujoco.mjtCone.mjCONE_PYRAMIDAL
    spec.option.iterations = physics.iterations
    spec.option.ls_iterations = physics.ls_iterations
    spec.option.tolerance = physics.tolerance

    spec.visual.global_.offwidth, spec.visual.global_.offheight = 1920, 1080
    world = spec.worldbody
    grid = spec.add_texture(
        name="grid",
        type=mujoco.mjtTexture.mjTEXTURE_2D,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        rgb1=[0.93, 0.94, 0.95],
        rgb2=[0.83, 0.85, 0.87],
        width=256,
        height=256,
    )
    material = spec.add_material(name="grid", texrepeat=[2, 2], texuniform=True)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = grid.name
    world.add_geom(
        name="floor",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[0, 0, 1],
        material="grid",
        contype=0,
        conaffinity=0,
    )
    world.add_light(pos=[0, -3, 6], dir=[0, 0.4, -1], type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL)
    return spec


def inertial(body: mujoco.MjsBody, segment: Segment, half: Triple | None = None) -> None:
    """Give ``body`` the mass, centre of mass and inertia of ``segment``.

    Args:
      half: of the box whose shape the inertia has, m; None where only the pitch axis moves.
    """
    body.explicitinertial = True
    body.mass = segment.mass
    body.ipos = [segment.com[0], 0.0, segment.com[1]]
    if half is None:  # the other axes complete a physical (triangle) inertia
        body.inertia = [segment.inertia, segment.inertia, 0.5 * segment.inertia]
        return
    x, y, z = (side**2 for side in half)
    pitching = segment.inertia / (x + z)
    body.inertia = [pitching * (y + z), segment.inertia, pitching * (x + y)]


def box(body: mujoco.MjsBody, name: str, centre: Triple, half: Triple, rgba: list[float]) -> None:
    """A box that is drawn for a segment; it has no mass and touches nothing."""
    body.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=list(centre),
        size=list(half),
        rgba=rgba,
        contype=0,
        conaffinity=0,
        group=DRAWN,
        mass=0,
    )


def hinge(body: mujoco.MjsBody, name: str, axis: Triple, damping: float = 0.0) -> None:
    """A joint at the origin of ``body`` that turns it about ``axis``; ``damping`` in N m s/rad."""
    body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=list(axis), damping=damping)


def trunk(torso: mujoco.MjsBody, body: Body) -> None:
    """The torso's boxes and its IMU."""
    high, head = 0.8 * body.torso.length, 0.2 * body.torso.length
    grey = [0.35, 0.38, 0.42, 1.0]
    depth, breadth = TRUNK_DEPTH * body.height, TRUNK_BREADTH * body.height
    box(torso, "trunk", (0.0, 0.0, high / 2), (depth, breadth, high / 2), grey)
    box(torso, "head", (0.0, 0.0, high + 0.55 * head), (0.8 * depth, 0.4 * breadth, 0.45 * head), grey)
    torso.add_site(name="imu", pos=[0, 0, body.torso.com[1]], size=[0.01 * body.height] * 3)


def leg(
    spec: mujoco.MjSpec,
    torso: mujoco.MjsBody,
    side: str,
    body: Body,
    scale: Similarity,
    physics: PhysicsConfig,
    spatial: bool,
) -> None:
    """Thigh, shank and foot.

    Args:
      spatial: the hip has its place beside the torso's middle and can abduct, the foot can turn in and
        stands on four corners; otherwise the leg is in the plane, on heel and toe, and only drawn aside.
    """
    rgba, left = _COLOURS[side], 1.0 if side == "left" else -1.0
    hip, drawn = (HIP_WIDTH * body.height * left, 0.0) if spatial else (0.0, HIP_WIDTH * body.height * left)
    width = LEG_WIDTH * body.height

    half = (1.2 * width, width, body.thigh.length / 2)
    thigh = torso.add_body(name=f"thigh_{side}", pos=[0, hip, 0])
    inertial(thigh, body.thigh, half if spatial else None)
    if spatial:
        hinge(thigh, f"abduction_{side}", (left, 0.0, 0.0))
    hinge(thigh, f"hip_{side}", (0.0, -1.0, 0.0))
    box(thigh, f"thigh_{side}", (0.0, drawn, -body.thigh.length / 2), half, rgba)

    half = (width, 0.8 * width, body.shank.length / 2)
    shank = thigh.add_body(name=f"shank_{side}", pos=[0, 0, -body.thigh.length])
    inertial(shank, body.shank, half if spatial else None)
    hinge(shank, f"knee_{side}", (0.0, 1.0, 0.0))
    box(shank, f"shank_{side}", (0.0, drawn, -body.shank.length / 2), half, rgba)

    damping = physics.ankle_damping * scale.rotational_damping
    middle, reach = (body.heel + body.toe) / 2, (body.toe - body.heel) / 2
    foot = shank.add_body(name=f"foot_{side}", pos=[0, 0, -body.shank.length])
    inertial(foot, body.foot, (reach, width, 0.5 * body.foot.length) if spatial else None)
    hinge(foot, f"ankle_{side}", (0.0, -1.0, 0.0), damping)
    if spatial:
        hinge(foot, f"inversion_{side}", (-left, 0.0, 0.0), damping)
    half = (reach, width, 0.25 * body.foot.length)
    box(foot, f"foot_{side}", (middle, drawn, -0.75 * body.foot.length), half, rgba)
    radius = SOLE_RADIUS * body.height
    edge = width - radius
    rows = (("_inner", -left * edge), ("_outer", left * edge)) if spatial else (("", 0.0),)
    for row, y in rows:
        for end, x in (("heel", body.heel + radius), ("toe", body.toe - radius)):
            ball(foot, f"{end}{row}_{side}", (x, y, radius - body.foot.length), radius)
            timeconst = physics.heel_timeconst if end == "heel" else physics.contact_timeconst
            tread(spec, f"{end}{row}_{side}", physics, timeconst)
    foot.add_site(
        name=f"sole_{side}",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=[middle, 0, -body.foot.length + radius],
        size=[reach + radius, width, 2 * radius],
        rgba=[0, 0, 0, 0],
    )


def ball(body: mujoco.MjsBody, name: str, pos: Triple, radius: float) -> None:
    """A sphere that touches what it is paired with."""
    body.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        pos=list(pos),
        size=[radius, 0, 0],
        contype=0,
        conaffinity=0,
        group=COLLIDES,
        mass=0,
        rgba=[0.3, 0.3, 0.3, 0.3],
    )


def tread(spec: mujoco.MjSpec, name: str, physics: PhysicsConfig, timeconst: float) -> None:
    """The contact of the floor with the ball called ``name``; its time constant in s."""
    spec.add_pair(
        name=name,
        geomname1="floor",
        geomname2=name,
        condim=3,
        friction=[physics.friction, physics.friction, 0.005, 0.0001, 0.0001],
        solref=[timeconst, 1.0],
    )


def actuator(spec: mujoco.MjSpec, joint: str, limit: float, gain: float, bias: tuple[float, float]) -> None:
    """On ``joint``: torque = gain x command + bias[0] x angle + bias[1] x rate, within +-``limit`` N m."""
    zeros = [0.0] * 7
    servo = dict(biastype=mujoco.mjtBias.mjBIAS_AFFINE) if any(bias) else {}
    spec.add_actuator(
        name=joint,
        target=joint,
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        forcelimited=True,
        forcerange=[-limit, limit],
        gaintype=mujoco.mjtGain.mjGAIN_FIXED,
        gainprm=[gain, 0, 0, *zeros],
        biasprm=[0, *bias, *zeros],
        **servo,
    )


def effort(spec: mujoco.MjSpec, joint: str, limit: float) -> None:
    """On ``joint``: the torque that it is told, within +-``limit`` N m."""
    actuator(spec, joint, limit, 1.0, (0.0, 0.0))


def servos(spec: mujoco.MjSpec, side: str, scale: Similarity, physics: PhysicsConfig) -> None:
    """Hip velocity servo, knee position servo, ankle effort; an effort each where torques are told."""
    if physics.drives != "servo":
        for number, (joint, limit) in enumerate(
            (
                ("hip", physics.hip_limit),
                ("knee", physics.knee_limit),
                ("ankle", physics.ankle_limit),
            )
        ):
            most = strength.peak(physics.actuators, number)
            effort(spec, f"{joint}_{side}", (limit if most is None else most) * scale.torque)
        return
    hip = physics.hip_gain * scale.rotational_damping
    kp = physics.knee_stiffness * scale.torque
    kv = physics.knee_damping * scale.rotational_damping
    actuator(spec, f"hip_{side}", physics.hip_limit * scale.torque, hip, (0.0, -hip))
    actuator(spec, f"knee_{side}", physics.knee_limit * scale.torque, kp, (-kp, -kv))
    effort(spec, f"ankle_{side}", physics.ankle_limit * scale.torque)


def instruments(spec: mujoco.MjSpec) -> None:
    """IMU, then the force under each sole; in the order of `jaxwalk.model.physics.readings_of`."""
    sensor(spec, "imu_velocity", "FRAMELINVEL", "imu")
    sensor(spec, "imu_up", "FRAMEZAXIS", "imu")
    sensor(spec, "imu_gyro", "GYRO", "imu")
    for side in SIDES:
        sensor(spec, f"touch_{side}", "TOUCH", f"sole_{side}")


def sensor(spec: mujoco.MjSpec, name: str, kind: str, site: str) -> None:
    """A sensor at ``site``; ``kind`` as in MuJoCo's ``mjSENS_`` constants."""
    spec.add_sensor(
        name=name,
        type=getattr(mujoco.mjtSensor, f"mjSENS_{kind}"),
        objtype=mujoco.mjtObj.mjOBJ_SITE,
        objname=site,
    )
