"""The planar walker as MJCF, built with ``mujoco.MjSpec``.

Conventions: x forward, z up. Root: slide x, slide z, hinge pitch, at the hip, so that
``qpos[:3]`` is hip x, hip height, torso pitch (positive leans forward). Joint angles:
hip flexion, knee flexion and ankle dorsiflexion are positive.
"""

from __future__ import annotations

import mujoco

from jaxwalk.body import Body, Segment
from jaxwalk.config import GRAVITY, PhysicsConfig
from jaxwalk.similarity import Similarity

SIDES = ("left", "right")
JOINTS = ("root_x", "root_z", "root_pitch") + tuple(
    f"{joint}_{side}" for side in SIDES for joint in ("hip", "knee", "ankle")
)
SEGMENTS = ("torso",) + tuple(
    f"{segment}_{side}" for side in SIDES for segment in ("thigh", "shank", "foot")
)  # the bodies, after the world
DRAWN, COLLIDES = 1, 3  # geom groups: boxes are drawn, spheres collide
SOLE_RADIUS = 0.01  # fraction of height


def _inertial(body: mujoco.MjsBody, segment: Segment) -> None:
    body.explicitinertial = True
    body.mass = segment.mass
    body.ipos = [segment.com[0], 0.0, segment.com[1]]
    # Only the pitch axis moves in the plane; the others complete a physical (triangle) inertia.
    body.inertia = [segment.inertia, segment.inertia, 0.5 * segment.inertia]


def _box(
    body: mujoco.MjsBody,
    name: str,
    centre: tuple[float, float, float],
    half: tuple[float, float, float],
    rgba: list[float],
) -> None:
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


def _leg(
    spec: mujoco.MjSpec,
    torso: mujoco.MjsBody,
    side: str,
    body: Body,
    scale: Similarity,
    physics: PhysicsConfig,
) -> None:
    rgba = [0.20, 0.45, 0.75, 1.0] if side == "left" else [0.85, 0.45, 0.20, 1.0]
    lateral = 0.05 * body.height * (1 if side == "left" else -1)  # drawing only: the plane has no y
    width = 0.025 * body.height
    hinge = dict(type=mujoco.mjtJoint.mjJNT_HINGE)

    thigh = torso.add_body(name=f"thigh_{side}", pos=[0, 0, 0])
    _inertial(thigh, body.thigh)
    thigh.add_joint(name=f"hip_{side}", axis=[0, -1, 0], **hinge)
    _box(
        thigh,
        f"thigh_{side}",
        (0.0, lateral, -body.thigh.length / 2),
        (1.2 * width, width, body.thigh.length / 2),
        rgba,
    )

    shank = thigh.add_body(name=f"shank_{side}", pos=[0, 0, -body.thigh.length])
    _inertial(shank, body.shank)
    shank.add_joint(name=f"knee_{side}", axis=[0, 1, 0], **hinge)
    _box(
        shank,
        f"shank_{side}",
        (0.0, lateral, -body.shank.length / 2),
        (width, 0.8 * width, body.shank.length / 2),
        rgba,
    )

    foot = shank.add_body(name=f"foot_{side}", pos=[0, 0, -body.shank.length])
    _inertial(foot, body.foot)
    foot.add_joint(
        name=f"ankle_{side}",
        axis=[0, -1, 0],
        damping=physics.ankle_damping * scale.rotational_damping,
        **hinge,
    )
    middle, half = (body.heel + body.toe) / 2, (body.toe - body.heel) / 2
    _box(
        foot,
        f"foot_{side}",
        (middle, lateral, -0.75 * body.foot.length),
        (half, width, 0.25 * body.foot.length),
        rgba,
    )
    radius = SOLE_RADIUS * body.height
    for end, x in (("heel", body.heel + radius), ("toe", body.toe - radius)):
        name = f"{end}_{side}"
        foot.add_geom(
            name=name,
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            pos=[x, 0, radius - body.foot.length],
            size=[radius, 0, 0],
            contype=0,
            conaffinity=0,
            group=COLLIDES,
            mass=0,
            rgba=[0.3, 0.3, 0.3, 0.3],
        )
        friction = [physics.friction, physics.friction, 0.005, 0.0001, 0.0001]
        spec.add_pair(
            name=name,
            geomname1="floor",
            geomname2=name,
            condim=3,
            friction=friction,
            solref=[physics.contact_timeconst, 1.0],
        )
    foot.add_site(
        name=f"sole_{side}",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=[middle, 0, -body.foot.length + radius],
        size=[half + radius, width, 2 * radius],
        rgba=[0, 0, 0, 0],
    )


def _actuators(spec: mujoco.MjSpec, side: str, scale: Similarity, physics: PhysicsConfig) -> None:
    def add(joint: str, limit: float, **kwargs: object) -> None:
        spec.add_actuator(
            name=f"{joint}_{side}",
            target=f"{joint}_{side}",
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            forcelimited=True,
            forcerange=[-limit * scale.torque, limit * scale.torque],
            **kwargs,
        )

    affine = dict(gaintype=mujoco.mjtGain.mjGAIN_FIXED, biastype=mujoco.mjtBias.mjBIAS_AFFINE)
    hip = physics.hip_gain * scale.rotational_damping
    kp = physics.knee_stiffness * scale.torque
    kv = physics.knee_damping * scale.rotational_damping
    zeros = [0.0] * 7
    add("hip", physics.hip_limit, gainprm=[hip, 0, 0, *zeros], biasprm=[0, 0, -hip, *zeros], **affine)
    add("knee", physics.knee_limit, gainprm=[kp, 0, 0, *zeros], biasprm=[0, -kp, -kv, *zeros], **affine)
    add("ankle", physics.ankle_limit, gainprm=[1, 0, 0, *zeros])


def build(body: Body, physics: PhysicsConfig) -> mujoco.MjSpec:
    """The planar walker of ``body``: 9 degrees of freedom, 4 foot contacts, 6 actuators.

    Actuators, three a side: hip velocity servo (rad/s), knee position servo
    (rad), ankle effort (N m), left then right. Sensors: IMU at the torso's centre of
    mass (velocity, up axis, gyro) and a touch sensor under each foot.
    """
    scale = Similarity.of(body.height, body.mass)
    spec = mujoco.MjSpec()
    spec.modelname = "jaxwalk planar walker"
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

    torso = world.add_body(name="torso", pos=[0, 0, 0])
    _inertial(torso, body.torso)
    for name, kind, axis in zip(
        JOINTS, ("SLIDE", "SLIDE", "HINGE"), ([1, 0, 0], [0, 0, 1], [0, 1, 0]), strict=False
    ):
        torso.add_joint(name=name, type=getattr(mujoco.mjtJoint, f"mjJNT_{kind}"), axis=axis)
    trunk, head = 0.8 * body.torso.length, 0.2 * body.torso.length
    grey = [0.35, 0.38, 0.42, 1.0]
    depth, breadth = 0.05 * body.height, 0.09 * body.height
    _box(torso, "trunk", (0.0, 0.0, trunk / 2), (depth, breadth, trunk / 2), grey)
    _box(torso, "head", (0.0, 0.0, trunk + 0.55 * head), (0.8 * depth, 0.4 * breadth, 0.45 * head), grey)
    torso.add_site(name="imu", pos=[0, 0, body.torso.com[1]], size=[0.01 * body.height] * 3)
    for side in SIDES:
        _leg(spec, torso, side, body, scale, physics)
        _actuators(spec, side, scale, physics)

    def sensor(name: str, kind: str, target: str) -> None:
        spec.add_sensor(
            name=name,
            type=getattr(mujoco.mjtSensor, f"mjSENS_{kind}"),
            objtype=mujoco.mjtObj.mjOBJ_SITE,
            objname=target,
        )

    sensor("imu_velocity", "FRAMELINVEL", "imu")
    sensor("imu_up", "FRAMEZAXIS", "imu")
    sensor("imu_gyro", "GYRO", "imu")
    for side in SIDES:
        sensor(f"touch_{side}", "TOUCH", f"sole_{side}")
    return spec
