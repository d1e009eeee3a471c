"""The controllers' numbers, those of the reference body: what a footstep is like, and what ends it."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any, Literal

from jaxwalk.config.compliant import CompliantConfig
from jaxwalk.config.step_plan import StepPlanConfig

Form = Literal["rigid", "compliant"]
"""The controllers: the paper's, of stiff legs; or legs that yield and steps that can be changed."""

Steps = Literal["told", "planned"]
"""Who settles length and time of a step: the policy; or the controllers, whose plan the policy may change."""


@dataclass(frozen=True)
class GaitConfig:
    """The low-level controllers. Lengths, times, rates and torques are the reference body's."""

    form: Form = "compliant"
    """rigid: as the paper's, by servos. compliant: impedances and push-off, by torques (``compliant``)."""
    compliant: CompliantConfig = field(default_factory=CompliantConfig)
    """The numbers of the latter."""
    steps: Steps = "planned"
    """told: the policy commands length and time of a step. planned: compliant legs plan both by the capture
    point, anew at every tick, and the policy says what is to be changed of that (``step_plan``)."""
    step_plan: StepPlanConfig = field(default_factory=StepPlanConfig)
    """The numbers of the latter."""
    speed_desired: float = 1.0
    """Forward speed that is aimed at, v_desire, m/s (not scaled with the body)."""
    length_nominal: float = 0.6869
    """Commanded step length before learning, m."""
    duration_nominal: float = 0.4806
    """Commanded duration before learning, s: of the whole step (compliant), or of early swing (rigid)."""
    length_min: float = -0.7
    """Shortest step that can be commanded, m; a negative one is a step back (compliant)."""
    length_max: float = 0.95
    """Longest step that can be commanded, m."""
    duration_min: float = 0.15
    """Shortest duration that can be commanded, s."""
    duration_max: float = 1.2
    """Longest duration that can be commanded, s."""

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
    toe_off_form: Literal["linear", "paper", "one-leg"] = "linear"
    """Toe-off torque: linear in the speed lost; the paper's eqs 14-22; or these with one leg's inertia, which
    policies of before have."""
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

    @property
    def answers(self) -> tuple[tuple[Any, Any], tuple[Any, Any]]:
        """What a policy's least and greatest answers stand for: (length m, duration s) of a step, or of what
        is changed of the plan; numbers of whatever kind the fields are."""
        if self.steps == "planned":
            length, duration = self.step_plan.change_length, self.step_plan.change_duration
            return (-length, -duration), (length, duration)
        return (self.length_min, self.duration_min), (self.length_max, self.duration_max)


SWITCHES = ("form", "steps", "toe_off_form", "toe_off_latched", "back_step")
"""Fields that are no numbers."""
SHARED = (
    "speed_desired", "length_nominal", "duration_nominal", "length_min", "length_max", "duration_min",
    "duration_max", "touchdown_ahead", "touchdown_force", "fall_height", "fall_pitch", "stall_seconds",
)  # fmt: skip
"""Numbers that both forms go by."""
RIGID = tuple(f.name for f in fields(GaitConfig) if f.name not in (*SWITCHES, "compliant", "step_plan"))
"""Numbers that rigid legs go by."""
