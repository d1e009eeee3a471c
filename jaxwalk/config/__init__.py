"""Everything that can be chosen: frozen dataclasses, their checks (`validate`), and named `presets`.

Nothing here imports jax, so that ``jaxwalk --help`` stays fast.
"""

from jaxwalk.config.circumstances import CircumstancesConfig
from jaxwalk.config.compliant import CompliantConfig
from jaxwalk.config.formats import of_dict, to_dict
from jaxwalk.config.gait import Form, GaitConfig
from jaxwalk.config.schema import Config, Kernels, Observable
from jaxwalk.config.step_plan import StepPlanConfig
from jaxwalk.config.training import DDPGConfig, ESConfig, PushConfig, RewardConfig, TaskConfig, TrainConfig
from jaxwalk.config.walker import (
    DELAY_MOST,
    GRAVITY,
    REFERENCE_HEIGHT,
    REFERENCE_MASS,
    Actuators,
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
    "DELAY_MOST",
    "GRAVITY",
    "REFERENCE_HEIGHT",
    "REFERENCE_MASS",
    "Actuators",
    "BodyConfig",
    "BodyModel",
    "CircumstancesConfig",
    "CompliantConfig",
    "Config",
    "DDPGConfig",
    "Drive",
    "ESConfig",
    "Engine",
    "Form",
    "GaitConfig",
    "GazeboConfig",
    "Kernels",
    "Observable",
    "PhysicsConfig",
    "PidConfig",
    "PushConfig",
    "RewardConfig",
    "SensorConfig",
    "StepPlanConfig",
    "TaskConfig",
    "TrainConfig",
    "of_dict",
    "to_dict",
]
