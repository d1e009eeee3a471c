"""The walker: its body, the physics that move it, its sensors.

Lengths, gains and torques are those of the reference body (1.8 m, 75 kg); ``jaxwalk.model.similarity``
carries them to other bodies.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

REFERENCE_HEIGHT = 1.8  # m
REFERENCE_MASS = 75.0  # kg
GRAVITY = 9.81  # m/s^2
DELAY_MOST = 0.04  # s by which instruments may be told late

BodyModel = Literal["planar", "walls"]
"""How a body moves: in the plane, or in space between two walls, as the paper's: ``jaxwalk.model.mjcf``."""

Engine = Literal["mjx", "mujoco", "ode", "ode-quick"]
"""What moves the plant: MJX; C MuJoCo solved to convergence (see ``jaxwalk.model.c_mujoco``); or ODE, by its
world step or its quick step (see ``jaxwalk.model.ode``)."""


@dataclass(frozen=True)
class BodyConfig:
    """Who walks."""

    height: float = REFERENCE_HEIGHT
    """Stature, m."""
    mass: float = REFERENCE_MASS
    """Body mass, kg."""
    table: Literal["winter", "box"] = "winter"
    """Anthropometric table: Winter's segments, or the paper's uniform boxes."""
    model: BodyModel = "planar"
    """In the plane, or free between two frictionless walls with a small gap, as the paper's."""


Drive = Literal["servo", "gazebo", "torque"]
"""What carries out the controllers' commands: MuJoCo's servos, Gazebo's ways, or motors that give the torque
they are told."""

Actuators = Literal["person", "exoskeleton", "unlimited"]
"""Whose strength the joints have: see ``jaxwalk.model.strength``."""


@dataclass(frozen=True)
class PidConfig:
    """gazebo: a joint's PID, from the error of its velocity to its torque."""

    proportional: float = 0.0
    """N m s/rad."""
    integral: float = 0.0
    """N m/rad."""
    derivative: float = 0.0
    """kg m^2."""
    windup: float = 0.0
    """Largest torque that the integral may come to, N m."""


@dataclass(frozen=True)
class GazeboConfig:
    """The gains of ``--physics.drives gazebo``; the joints' torque limits are those of the servos."""

    hip: PidConfig = PidConfig(210.0, 300.0, 0.05, 60.0)
    """Follows the commanded rate."""
    knee: PidConfig = PidConfig(40.0, 250.0, 0.004, 40.0)
    """Follows the rate that brings it to the commanded angle."""
    ankle: PidConfig = PidConfig(0.0, 0.0, 0.0, 0.0)
    """Told to stand still. The paper's ankle is passive: efforts alone move it."""
    abduction: PidConfig = PidConfig(100.0, 1500.0, 0.0, 200.0)
    """walls: told to stand still."""
    knee_position_gain: float = 15.0
    """Rate asked of the knee for each rad that it is off its angle, 1/s."""
    knee_rate_max: float = 11.0
    """Largest rate asked of it, rad/s."""
    retraction_seconds: float = 0.05
    """How long the effort lasts that brings the foot back up after toe-off, s."""


@dataclass(frozen=True)
class PhysicsConfig:
    """How MuJoCo integrates the body."""

    timestep: float = 0.002
    """Length of one tick, s."""
    solver: Literal["own", "mjx"] = "own"
    """What solves the equations of motion: the package's own Newton method, many times as fast, for models of
    the package's kind; or plain ``mjx.step``, for whoever changes the MJCF."""
    iterations: int = 3
    """Newton iterations a tick; of MuJoCo's own solver, at most."""
    ls_iterations: int = 5
    """Line-search iterations of MuJoCo's own solver, at most (ours searches exactly)."""
    tolerance: float = 1e-6
    """MuJoCo's own solver stops early when its scaled improvement falls below this."""
    contact_timeconst: float = 0.015
    """Time constant of contacts (MuJoCo solref[0]), under the toe and at walls, s; at least two ticks."""
    heel_timeconst: float = 0.03
    """The same under the heel, s: people's heel pad and shoe take up most of a landing."""
    friction: float = 0.9
    """Sliding friction between sole and floor."""
    hip_gain: float = 290.0
    """Velocity servo gain of the hip, N m s/rad."""
    hip_limit: float = 250.0
    """Largest hip torque, N m; with a strength of ``actuators``, that is the limit instead."""
    knee_stiffness: float = 1200.0
    """Position gain of the knee servo, N m/rad."""
    knee_damping: float = 100.0
    """Velocity gain of the knee servo, N m s/rad."""
    knee_limit: float = 200.0
    """Largest knee torque, N m."""
    ankle_limit: float = 150.0
    """Largest ankle torque, N m."""
    ankle_damping: float = 1.0
    """Passive ankle damping c of the paper, N m s/rad."""
    abduction_gain: float = 100.0
    """walls: velocity PID that holds the hip's abduction still, proportional to its rate, N m s/rad."""
    abduction_integral: float = 1500.0
    """walls: the same, to the integral of its rate, N m/rad."""
    abduction_limit: float = 200.0
    """walls: largest abduction torque, N m."""
    drives: Drive = "torque"
    """What moves the joints: servos within the solver, Gazebo's PIDs and timed efforts, or torques."""
    actuators: Actuators = "person"
    """torque: the strength that the joints have at each rate. unlimited: the limits above alone."""
    gazebo: GazeboConfig = field(default_factory=GazeboConfig)
    """The gains of the latter."""


@dataclass(frozen=True)
class SensorConfig:
    """What the instruments add to the truth. Every figure is multiplied by ``noise``."""

    noise: float = 1.0
    """Scale of all noise and bias: 1 realistic, 0 none."""
    velocity_std: float = 0.03
    """White noise of the torso's forward velocity, m/s."""
    velocity_bias: float = 0.01
    """Spread of the velocity's constant error between walkers, m/s."""
    acceleration_std: float = 0.3
    """White noise of the torso's forward acceleration, m/s^2."""
    acceleration_bias: float = 0.05
    """Spread of the accelerometer's constant error between walkers, m/s^2."""
    pitch_std: float = 0.002
    """White noise of the torso's pitch, rad."""
    pitch_bias: float = 0.005
    """Spread of the pitch's constant error between walkers, rad."""
    gyro_std: float = 0.01
    """White noise of the torso's pitch rate, rad/s."""
    encoder_std: float = 0.0005
    """White noise of every joint angle, rad."""
    encoder_rate_std: float = 0.01
    """White noise of every joint velocity, rad/s."""
    touch_std: float = 2.0
    """White noise of the sole's force, N."""
    mean_window: int = 10
    """Ticks in the moving mean of velocity and acceleration."""
    kalman_process: float = 0.5
    """Kalman filter: spread of the acceleration's change per tick, m/s^2."""
    kalman_velocity: float = 0.02
    """Kalman filter: assumed error of the averaged velocity, m/s."""
    kalman_acceleration: float = 1.0
    """Kalman filter: assumed error of the averaged acceleration, m/s^2."""
