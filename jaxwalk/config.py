"""Static configuration: frozen dataclasses that are the command line and the run folder's JSON.

Nothing here imports jax, so that ``jaxwalk --help`` stays fast. Lengths, gains and
torques are those of the reference body (1.8 m, 75 kg); ``jaxwalk.similarity`` carries
them to other bodies.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import Literal

REFERENCE_HEIGHT = 1.8  # m
REFERENCE_MASS = 75.0  # kg
GRAVITY = 9.81  # m/s^2

Observable = Literal[
    "speed", "pitch", "zmp", "step_length", "pitch_rate", "acceleration",
    "speed_desired", "height", "com_ahead",
]  # fmt: skip

BodyModel = Literal["planar", "walls"]
"""How a body moves: in the plane, or in space between two walls, as the paper's (see ``jaxwalk.mjcf``)."""

Engine = Literal["mjx", "mujoco"]
"""What moves the plant: MJX, or C MuJoCo solved to convergence (see ``jaxwalk.c_mujoco``)."""


Kernels = Literal["auto", "off"]
"""Whether a walker's tick is made into native code (see ``jaxwalk.kernels``)."""


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


Drive = Literal["servo", "gazebo"]
"""What carries out the controllers' commands: MuJoCo's servos, or Gazebo's ways (see ``jaxwalk.drives``)."""


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
    contact_timeconst: float = 0.006
    """Time constant of contacts (MuJoCo solref[0]), s; at least two ticks."""
    friction: float = 0.9
    """Sliding friction between sole and floor."""
    hip_gain: float = 290.0
    """Velocity servo gain of the hip, N m s/rad."""
    hip_limit: float = 250.0
    """Largest hip torque, N m."""
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
    drives: Drive = "servo"
    """What moves the joints: servos within the solver, or Gazebo's velocity PIDs and timed efforts."""
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


@dataclass(frozen=True)
class GaitConfig:
    """The low-level controllers. Lengths, times, rates and torques are the reference body's."""

    speed_desired: float = 1.0
    """Forward speed that is aimed at, v_desire, m/s (not scaled with the body)."""
    length_nominal: float = 0.633
    """Commanded step length before learning, m: the height-to-stride-length ratio (Boulic et al.)."""
    duration_nominal: float = 0.12
    """Commanded early-swing duration before learning, s."""
    length_min: float = 0.45
    """Shortest step that can be commanded, m."""
    length_max: float = 0.95
    """Longest step that can be commanded, m."""
    duration_min: float = 0.05
    """Shortest early swing that can be commanded, s."""
    duration_max: float = 0.2
    """Longest early swing that can be commanded, s."""

    pitch_nominal: float = 0.0765
    """phi0 of eq. 13: the pitch at which the stance hip turns as fast as the stance leg, rad."""
    stance_rate_max: float = 6.53
    """Largest hip rate that the stance controller commands, rad/s."""
    stance_speed_min: float = 0.918
    """The stance controller never takes the hip to be slower than this, m/s."""

    swing_rate_max: float = 10.0
    """Largest hip rate in early swing, rad/s."""
    swing_pitch_gain: float = 0.501
    """Share of the torso's pitch added to the swing hip's target (0: relative to the torso)."""
    swing_knee: float = 1.4
    """Knee flexion of the swing leg, rad."""
    swing_knee_share: float = 0.817
    """Share of early swing for which the knee stays bent."""
    swing_ankle: float = 0.174
    """Dorsiflexion of the swing foot, rad."""
    terminal_hip_gain: float = 16.0
    """Hip rate for each rad off target in terminal swing, 1/s."""
    ankle_stiffness: float = 77.0
    """Ankle servo in the air, N m/rad."""
    ankle_rate_gain: float = 1.0
    """Ankle servo in the air, N m s/rad."""

    toe_off_ankle: float = 0.6
    """Plantarflexion at which the push ends: a foot that left the floor would spin, rad."""
    toe_off_form: Literal["linear", "paper"] = "linear"
    """Toe-off torque: linear in the speed lost, or the paper's eqs 14-22."""
    toe_off_latched: bool = False
    """Torque and time of toe-off are set once, at touch-down, as in the paper; otherwise a walker that
    loses more speed while it pushes, pushes harder and longer."""
    toe_off_duration: float = 0.04
    """How long the ankle pushes, s."""
    toe_off_duration_min: float = 0.025
    """Shortest push: one weaker than ``toe_off_full`` is shorter too, so that a fast leg swings sooner, s."""
    toe_off_duration_max: float = 0.115
    """Longest push: a torque beyond the ankle's limit becomes time (equal angular impulse, eq. 21), s."""
    toe_off_full: float = 60.0
    """Torque from which a push lasts ``toe_off_duration``, N m."""
    toe_off_gain: float = 300.0
    """linear: torque for each m/s lost, N m s/m."""
    toe_off_speed: float = 1.3
    """The torso's speed at touch-down from which losses count, at 1 m/s desired, m/s: more than its mean."""

    back_step: bool = True
    """A walker that cannot pass over its stance foot puts the other foot down behind (not in the paper)."""
    back_step_margin: float = 0.06
    """How far behind the stance ankle the capture point is then, m."""
    back_step_reach: float = 0.1
    """How far behind the capture point the foot is put, m."""
    back_step_least: float = 0.1
    """How far behind the stance ankle it must be to count as landed, m."""
    back_step_force: float = 150.0
    """Sole force with which it counts as landed, N."""
    back_step_knee: float = 0.4
    """Knee flexion on the way, rad."""
    back_step_near: float = 0.3
    """Hip angle before its target at which the knee begins to straighten, rad."""

    restart_seconds: float = 0.9
    """A stance that lasts longer is a walker that stands, at ease on one leg (not in the paper), s."""
    restart_torque: float = 15.0
    """Its ankle then pulls it forward, out of that balance and into its next step, N m (0: never)."""

    touchdown_share: float = 0.639
    """Share of early swing before which a contact is no touch-down."""
    touchdown_ahead: float = 0.02
    """How far the landing ankle must be ahead of the other, m."""
    touchdown_force: float = 20.0
    """Sole force that counts as contact, N."""
    fall_height: float = 0.7
    """A hip lower than this share of its standing height is a fall."""
    fall_pitch: float = 1.0
    """A torso that leans further than this, either way, is a fall, rad."""
    stall_seconds: float = 2.5
    """A footstep that lasts longer is a stall, which ends the episode like a fall, s."""


@dataclass(frozen=True)
class PushConfig:
    """The pushes that walkers meet in training."""

    rate: float = 0.5
    """Mean number of pushes a second."""
    impulse_forward: float = 85.0
    """Largest push from behind, N s."""
    impulse_backward: float = 90.0
    """Largest push from the front, N s."""
    impulse_least: float = 0.45
    """Smallest push, as a share of the largest of its direction: what anybody survives teaches nothing."""
    duration: float = 0.1
    """How long the force lasts, s."""
    height_spread: float = 0.2
    """Pushes land within this distance of the torso's centre, m."""


@dataclass(frozen=True)
class DDPGConfig:
    """The learner. The preset ``paper`` holds Liu et al.'s values."""

    hidden: tuple[int, ...] = (64, 64)
    """Widths of the hidden layers of actor and critic (the paper's: 400 and 300)."""
    actor_lr: float = 2e-4
    """Learning rate of the actor."""
    critic_lr: float = 1e-3
    """Learning rate of the critic."""
    gamma: float = 0.8
    """Discount per footstep."""
    tau: float = 0.005
    """Share of the online parameters that enters the targets at each update."""
    average_rate: float = 5e-4
    """Share of the actor that enters the policy that is evaluated and kept, at each update (1: all)."""
    batch_size: int = 256
    """Transitions in one update."""
    replay_capacity: int = 262_144
    """Transitions that are remembered."""
    warmup: int = 4_000
    """Footsteps gathered before the first update."""
    start: Literal["nominal", "random"] = "nominal"
    """First answer of the actor: the nominal step (from the height-to-stride-length ratio, as in the paper),
    or one drawn from all that can be commanded."""
    critic_head_start: int = 1_000
    """Updates of the critic before the actor moves: an early critic would lead it astray."""
    updates_per_footstep: float = 0.5
    """Updates for each footstep gathered."""
    noise_start: float = 0.12
    """Standard deviation of the exploration noise at first, in units of half the action range."""
    noise_end: float = 0.04
    """The same at the end of training."""
    noise_spread: float = 4.0
    """Ratio of the noisiest to the quietest walker's exploration (1: all alike)."""
    layer_norm: bool = True
    """LayerNorm after each hidden layer of the critic."""
    weight_decay: float = 1e-4
    """Decoupled weight decay of the critic."""
    max_grad_norm: float = 10.0
    """Gradients are clipped to this global norm (0: never)."""
    normalize_observations: bool = True
    """Sampled observations are centred and scaled by running statistics."""
    twin: bool = False
    """TD3: two critics, the smaller one believed, with delayed actor and smoothed targets."""
    policy_delay: int = 2
    """TD3: critic updates for each actor update."""
    target_noise: float = 0.2
    """TD3: standard deviation of the smoothing noise on the target action."""
    target_noise_clip: float = 0.5
    """TD3: largest smoothing noise."""


@dataclass(frozen=True)
class RewardConfig:
    """The reward of one footstep: exp(-cost), cost a weighted sum of normalised squares."""

    speed_weight: float = 8.0
    """Weight of ((|v - v_desire| - tolerance) / 0.5 m/s)^2, where positive."""
    speed_tolerance: float = 0.025
    """How far the speed may be off at no cost, m/s: a little faster is a lot safer from the front."""
    pitch_weight: float = 0.5
    """Weight of (phi / 0.2 rad)^2."""
    zmp_weight: float = 0.1
    """Weight of (d_zmp / 0.3 m)^2."""
    length_weight: float = 0.02
    """Weight of ((l - l_nominal) / 0.3 m)^2, l_nominal being Boulic's step at v_desire."""
    fall: float = -10.0
    """Added when the walker falls."""


@dataclass(frozen=True)
class TrainConfig:
    """The training loop."""

    walkers: int = 256
    """Walkers that learn side by side."""
    footsteps: int = 80_000
    """Footsteps gathered before training ends."""
    window_ticks: int = 10
    """Ticks between two looks at whether a walker needs a decision."""
    episode_seconds: float = 30.0
    """A walker that still stands is started anew after this time (truncation)."""
    height_spread: float = 0.1
    """Statures are drawn uniformly within this share of the body's height."""
    mass_spread: float = 0.1
    """Masses (at given stature) are drawn uniformly within this share."""
    windows_per_report: int = 50
    """Windows between two lines of metrics; the loop runs on the device for so long."""
    evaluations: int = 16
    """Evaluations spread over training; the best ones' policies meet in the finals."""
    finalists: int = 3
    """How many meet there, under more pushes (1: none do, the best evaluation decides)."""
    checkpoint_seconds: float = 60.0
    """Least time between two checkpoints for ``--resume``; they are begun between reports, s (0: none)."""
    divergence_limit: int = 100
    """Updates skipped since the last evaluation, being not finite, beyond which training goes back to it."""
    divergence_events: int = 3
    """How many times training may come to that before the run stops."""


@dataclass(frozen=True)
class Config:
    """Everything that a run depends on, its seed aside."""

    body: BodyConfig = field(default_factory=BodyConfig)
    physics: PhysicsConfig = field(default_factory=PhysicsConfig)
    sensors: SensorConfig = field(default_factory=SensorConfig)
    gait: GaitConfig = field(default_factory=GaitConfig)
    pushes: PushConfig = field(default_factory=PushConfig)
    reward: RewardConfig = field(default_factory=RewardConfig)
    ddpg: DDPGConfig = field(default_factory=DDPGConfig)
    train: TrainConfig = field(default_factory=TrainConfig)
    observation: tuple[Observable, ...] = ("speed", "pitch", "zmp", "step_length", "pitch_rate")
    """What the policy is told at touch-down: the paper's state and the rate of its pitch."""
    kernels: Kernels = "auto"
    """auto: native code on a CPU and kernels on a GPU, where they can be made. off: XLA's own programs."""


def to_dict(config: Config) -> dict:
    """The configuration as plain JSON values."""
    return dataclasses.asdict(config)
