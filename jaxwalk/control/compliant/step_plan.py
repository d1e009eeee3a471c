"""The step that the controllers plan by themselves, anew at every tick: where the foot goes, and how soon.

The capture point runs away from the stance foot as exp(w0 t) (Koolen et al. 2012). Where it will be when
the step would usually end, less where it is then in steady walking, changes the step's length and makes it
sooner. If it lies behind the stance foot the body falls backward: the swing foot is sent behind that one.
A policy says what is to be changed of this (Johannink et al., "Residual reinforcement learning ...", 2019).
"""

from __future__ import annotations

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.config import GaitConfig
from jaxwalk.control.compliant import stance
from jaxwalk.control.posture import Posture
from jaxwalk.control.sensors import Estimate
from jaxwalk.control.step_clock import StepClock


def planned(
    config: GaitConfig, clock: StepClock, where: Posture, estimate: Estimate, error: Float[Array, ""]
) -> Float[Array, "2"]:
    """The step from now on: its length, m, negative for a step back; its time from the touch-down, s.

    Args:
      error: of the capture point at the landing, as of `stance.capture_error`.
    """
    own, legs, more = config.step_plan, config.compliant, stance.faster(config)
    usual = config.length_nominal + legs.length_speed * more
    length = usual + own.length_gain * error + own.pitch_gain * jnp.maximum(estimate.pitch, own.pitch_least)
    time = config.duration_nominal + legs.duration_speed * more - own.duration_gain * error
    # Ahead of the hip, as the capture point is: the stance ankle, and where the foot is put in a step back.
    stands, swing = where.ankle[clock.stance], where.ankle[1 - clock.stance]
    place = jnp.minimum(own.back_gain * where.capture - own.back_reach, stands - own.back_least)
    way = jnp.maximum(swing - place, own.back_beyond * (place - swing))
    time_back = jnp.clip(way / own.back_speed, own.back_soonest, own.back_time)
    back = where.capture - stands < -own.back_margin
    return jnp.where(
        back,
        jnp.stack([2.0 * place, clock.elapsed + time_back]),
        jnp.stack(
            [
                jnp.maximum(length, own.length_least),
                jnp.clip(time, own.duration_least, jnp.minimum(own.duration_most, config.duration_max)),
            ]
        ),
    )


def changed(config: GaitConfig, plan: Float[Array, "2"], change: Float[Array, "2"]) -> Float[Array, "2"]:
    """``plan`` with a policy's ``change`` of (length m, duration s), within what can be commanded; the time
    of a step back is not cut: of one that has lasted long nothing would be left."""
    low = jnp.stack([jnp.asarray(config.length_min), jnp.asarray(config.duration_min)])
    longest = jnp.maximum(config.duration_max, jnp.minimum(plan[1], config.step_plan.back_latest))
    high = jnp.stack([jnp.asarray(config.length_max), longest])
    return jnp.clip(plan + change, low, high)
