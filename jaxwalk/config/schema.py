"""The whole configuration: what the command line offers and a run folder's JSON holds."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from jaxwalk.config.circumstances import CircumstancesConfig
from jaxwalk.config.gait import GaitConfig
from jaxwalk.config.training import DDPGConfig, ESConfig, PushConfig, RewardConfig, TaskConfig, TrainConfig
from jaxwalk.config.walker import BodyConfig, PhysicsConfig, SensorConfig

Observable = Literal[
    "speed", "pitch", "zmp", "step_length", "pitch_rate", "acceleration",
    "speed_desired", "height", "com_ahead", "elapsed", "capture_ahead", "swing_ahead", "delay",
]  # fmt: skip

Kernels = Literal["auto", "off"]
"""Whether a walker's tick is made into native code (see ``jaxwalk.kernels``)."""


@dataclass(frozen=True)
class Config:
    """Everything that a run depends on, its seed aside."""

    body: BodyConfig = field(default_factory=BodyConfig)
    physics: PhysicsConfig = field(default_factory=PhysicsConfig)
    sensors: SensorConfig = field(default_factory=SensorConfig)
    gait: GaitConfig = field(default_factory=GaitConfig)
    task: TaskConfig = field(default_factory=TaskConfig)
    pushes: PushConfig = field(default_factory=PushConfig)
    circumstances: CircumstancesConfig = field(default_factory=CircumstancesConfig)
    reward: RewardConfig = field(default_factory=RewardConfig)
    ddpg: DDPGConfig = field(default_factory=DDPGConfig)
    es: ESConfig = field(default_factory=ESConfig)
    train: TrainConfig = field(default_factory=TrainConfig)
    observation: tuple[Observable, ...] = (
        "speed", "speed_desired", "pitch", "pitch_rate", "acceleration", "elapsed", "capture_ahead",
        "swing_ahead", "delay",
    )  # fmt: skip
    """What the policy is told when it is asked."""
    kernels: Kernels = "auto"
    """auto: native code on a CPU and kernels on a GPU, where they can be made. off: XLA's own programs."""
