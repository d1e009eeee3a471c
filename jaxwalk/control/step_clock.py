"""The step's clock: which leg stands, which phase each leg is in, when a foot has landed."""

from __future__ import annotations

from enum import IntEnum

import jax.numpy as jnp
from flax import struct
from jaxtyping import Array, Bool, Float, Int

from jaxwalk.config import GaitConfig
from jaxwalk.control.sensors import Estimate
from jaxwalk.model.kinematics import Skeleton, ankles


class Phase(IntEnum):
    """What one leg does."""

    STANCE = 0
    TOE_OFF = 1
    EARLY_SWING = 2
    TERMINAL_SWING = 3


class StepClock(struct.PyTreeNode):
    """Where in its step a walker is.

    Attributes:
      stance: index of the stance leg, 0 left, 1 right.
      elapsed: since the last touch-down, s.
      length, duration: of the step now under way: commanded length (m), early swing (s).
      toe_off, toe_off_seconds: ankle torque (N m, plantarflexion positive) and how long it
        lasts (s), set at touch-down; they may grow while it lasts.
    """

    stance: Int[Array, ""]
    elapsed: Float[Array, ""]
    length: Float[Array, ""]
    duration: Float[Array, ""]
    toe_off: Float[Array, ""]
    toe_off_seconds: Float[Array, ""]

    @property
    def is_stance(self) -> Bool[Array, "2"]:
        """[2] true for the stance leg."""
        return jnp.arange(2) == self.stance


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


def step_length(body: Skeleton, gait: StepClock, estimate: Estimate) -> Float[Array, ""]:
    """How far the swing ankle is ahead of the stance ankle, m."""
    x, _ = ankles(body, estimate.joints, estimate.pitch)
    return jnp.sum(jnp.where(gait.is_stance, -x, x))


def swing_force(gait: StepClock, estimate: Estimate) -> Float[Array, ""]:
    """The force under the sole of the swing leg, N."""
    return jnp.sum(jnp.where(gait.is_stance, 0.0, estimate.touch))


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
