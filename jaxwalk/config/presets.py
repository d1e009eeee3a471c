"""Named configurations: ``jaxwalk train --preset NAME``."""

from __future__ import annotations

import dataclasses
from typing import Literal

from jaxwalk.common import runtime
from jaxwalk.config.formats import of_dict
from jaxwalk.config.schema import Config
from jaxwalk.config.training import DDPGConfig, PushConfig, TrainConfig
from jaxwalk.config.walker import BodyConfig

PresetName = Literal["default", "gpu", "quick", "paper", "smoke", "rigid"]

# The walk of before: stiff legs, servos, one decision a step.
_RIGID = of_dict({"format": 1})

# Liu et al.'s constants; docs/paper-preset.md tells of each where it comes from. The paper walks one
# walker at a time and leaves open how fast the targets follow and how often the learner updates:
# Lillicrap et al.'s DDPG fills these in. The number of walkers stays ours, for time's sake.
_PAPER = dataclasses.replace(
    _RIGID,
    body=BodyConfig(table="box"),
    # A PID that is computed once a tick needs the shorter one, which is Gazebo's own.
    physics=dataclasses.replace(_RIGID.physics, drives="gazebo", timestep=0.001),
    ddpg=dataclasses.replace(
        _RIGID.ddpg,
        hidden=(400, 300),
        actor_lr=1e-8,
        critic_lr=2e-8,
        gamma=0.99,
        tau=0.001,
        average_rate=1.0,
        batch_size=32,
        replay_capacity=70_000,
        updates_per_footstep=1.0,
        critic_head_start=0,
        noise_spread=1.0,
        layer_norm=False,
        weight_decay=0.0,
        max_grad_norm=0.0,
        normalize_observations=False,
        twin=False,
    ),
    gait=dataclasses.replace(
        _RIGID.gait,
        pitch_nominal=0.02,  # phi0, printed
        toe_off_form="paper",
        toe_off_latched=True,
        toe_off_duration=0.05,
        toe_off_duration_min=0.05,
        toe_off_duration_max=0.05,
        back_step=False,
        restart_torque=0.0,
        # Not printed; found with scripts/tune_paper.py for these drives.
        toe_off_speed=1.23,
        toe_off_ankle=0.58,
        duration_nominal=0.1,
        stance_rate_max=5.0,
        swing_rate_max=11.0,
        swing_pitch_gain=0.14,
        swing_knee=1.2,
        swing_knee_share=0.55,
        swing_ankle=0.43,
        terminal_hip_gain=4.0,
        touchdown_share=0.65,
        touchdown_ahead=0.15,
    ),
    reward=dataclasses.replace(_RIGID.reward, speed_tolerance=0.0),
    train=dataclasses.replace(_RIGID.train, height_spread=0.0, mass_spread=0.0, window_ticks=20),
    observation=("speed", "pitch", "zmp", "step_length"),
)

# For one accelerator: more walkers, and larger batches. Not tried since walkers plan their steps.
_GPU = Config(
    ddpg=DDPGConfig(batch_size=4_096, updates_per_footstep=0.02),
    train=TrainConfig(walkers=4_096, footsteps=1_000_000),
)

# Half of the footsteps.
_QUICK = Config(train=TrainConfig(footsteps=250_000, evaluations=8))

# Seconds of work once compiled: does everything that training does, learns nothing.
_SMOKE = Config(
    ddpg=DDPGConfig(hidden=(32, 32), batch_size=32, replay_capacity=2_048, warmup=64, critic_head_start=10),
    pushes=PushConfig(rest=0.0),
    train=TrainConfig(walkers=8, footsteps=400, episode_seconds=5.0, evaluations=1, finalists=1),
)


def of_machine() -> PresetName:
    """The preset for what JAX finds here."""
    return "gpu" if runtime.has_accelerator() else "default"


PRESETS: dict[str, Config] = {
    "default": Config(), "gpu": _GPU, "quick": _QUICK, "paper": _PAPER, "smoke": _SMOKE,
    "rigid": _RIGID,
}  # fmt: skip
