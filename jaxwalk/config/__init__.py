"""Everything that can be chosen: frozen dataclasses, their checks (`validate`), and named `presets`.

Nothing here imports jax, so that ``jaxwalk --help`` stays fast.
"""

from jaxwalk.config.gait import GaitConfig
from jaxwalk.config.schema import Config, Kernels, Observable, to_dict
from jaxwalk.config.training import DDPGConfig, PushConfig, RewardConfig, TrainConfig
from jaxwalk.config.walker import (
    GRAVITY,
    REFERENCE_HEIGHT,
    REFERENCE_MASS,
    BodyConfig,
    BodyModel,
    Drive,
    Engine,
    GazeboConfig,
    PhysicsConfig,
    PidConfig,
    SensorConfig,
)

__all__ = [
    "GRAVITY",
    "REFERENCE_HEIGHT",
    "REFERENCE_MASS",
    "BodyConfig",
    "BodyModel",
    "Config",
    "DDPGConfig",
    "Drive",
    "Engine",
    "GaitConfig",
    "GazeboConfig",
    "Kernels",
    "Observable",
    "PhysicsConfig",
    "PidConfig",
    "PushConfig",
    "RewardConfig",
    "SensorConfig",
    "TrainConfig",
    "to_dict",
]
