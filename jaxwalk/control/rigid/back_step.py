"""The step back: what a walker does that cannot pass over its stance foot any more.

A walker that a push from the front has stopped is an inverted pendulum that falls backward: its
capture point, v sqrt(L/g) ahead of the hip, lies behind the stance foot (Koolen et al. 2012). No
step ahead can help it. It puts the swing foot down behind, stands on that, and since its hip is
then ahead of its foot, it falls forward into its next step. Not in the paper; ``GaitConfig.back_step``.
"""

from __future__ import annotations

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from jaxwalk.config import GaitConfig
from jaxwalk.control.posture import capture_point
from jaxwalk.control.rigid.phases import Phase, swing_phase
from jaxwalk.control.sensors import Estimate
from jaxwalk.control.step_clock import StepClock, step_length, swing_force
from jaxwalk.model.kinematics import Skeleton, ankles


def needed(config: GaitConfig, body: Skeleton, gait: StepClock, estimate: Estimate) -> Bool[Array, ""]:
    """Whether the walker falls backward over its stance foot; never while it still pushes off."""
    if not config.back_step:
        return jnp.bool_(False)
    x, _ = ankles(body, estimate.joints, estimate.pitch)
    behind = capture_point(body, estimate) < x[gait.stance] - config.back_step_margin
    return behind & (swing_phase(gait) != Phase.TOE_OFF)


def touched_down(config: GaitConfig, body: Skeleton, gait: StepClock, estimate: Estimate) -> Bool[Array, ""]:
    """Whether the swing foot carries a walker that needs it behind."""
    far = step_length(body, gait, estimate) < -config.back_step_least
    loaded = swing_force(gait, estimate) > config.back_step_force
    return needed(config, body, gait, estimate) & far & loaded


def swing(
    config: GaitConfig, body: Skeleton, gait: StepClock, estimate: Estimate
) -> tuple[Float[Array, ""], Float[Array, ""]]:
    """(hip rate rad/s, knee angle rad) that put the swing foot behind the capture point and the stance foot.

    The knee is bent while the foot must pass the other leg, and straight in time to land.
    """
    x, _ = ankles(body, estimate.joints, estimate.pitch)
    place = jnp.minimum(
        capture_point(body, estimate) - config.back_step_reach, x[gait.stance] - config.back_step_least
    )
    target = jnp.arcsin(jnp.clip(place / body.leg, -0.6, 0.6)) + estimate.pitch
    off = target - estimate.joints[1 - gait.stance, 0]
    rate = jnp.clip(config.terminal_hip_gain * off, -config.swing_rate_max, config.swing_rate_max)
    return rate, jnp.where(off < -config.back_step_near, config.back_step_knee, 0.0)
