"""The phases of a rigid walker's step, by the time since touch-down, and when its swing foot has landed."""

from __future__ import annotations

from enum import IntEnum

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from jaxwalk.config import GaitConfig
from jaxwalk.control.sensors import Estimate
from jaxwalk.control.step_clock import StepClock, step_length, swing_force
from jaxwalk.model.kinematics import Skeleton


class Phase(IntEnum):
    """What one leg does."""

    STANCE = 0
    TOE_OFF = 1
    EARLY_SWING = 2
    TERMINAL_SWING = 3


def swing_phase(gait: StepClock) -> Int[Array, ""]:
    """The `Phase` of the leg that is not in stance."""
    early = gait.elapsed >= gait.toe_off_seconds
    terminal = gait.elapsed >= gait.toe_off_seconds + gait.duration
    return jnp.int32(Phase.TOE_OFF) + early.astype(jnp.int32) + terminal.astype(jnp.int32)


def swing_progress(gait: StepClock) -> Float[Array, ""]:
    """Share of early swing that is over: negative in toe-off, above 1 in terminal swing."""
    return (gait.elapsed - gait.toe_off_seconds) / gait.duration


def pressed(
    config: GaitConfig, gait: StepClock, torque: Float[Array, ""], seconds: Float[Array, ""]
) -> StepClock:
    """The toe-off under way, made stronger and longer where ``torque`` N m and ``seconds`` ask for more.

    Eqs 14-22 set both from the speed lost at touch-down. A push from the front during toe-off
    takes more, which nothing later in the step could give back: the ankle is passive from then on.
    """
    if config.toe_off_latched:
        return gait
    pressing = gait.elapsed < gait.toe_off_seconds
    return gait.replace(
        toe_off=jnp.where(pressing, jnp.maximum(gait.toe_off, torque), gait.toe_off),
        toe_off_seconds=jnp.where(pressing, jnp.maximum(gait.toe_off_seconds, seconds), gait.toe_off_seconds),
    )


def touched_down(config: GaitConfig, body: Skeleton, gait: StepClock, estimate: Estimate) -> Bool[Array, ""]:
    """Whether the swing foot has landed ahead: late enough, far enough, with force enough.

    One that can step back and moves backward keeps its stance: the foot ahead could not carry it.
    """
    return (
        (swing_progress(gait) > config.touchdown_share)
        & (step_length(body, gait, estimate) > config.touchdown_ahead)
        & (swing_force(gait, estimate) > config.touchdown_force)
        & ((estimate.speed > 0) | (not config.back_step))
    )
