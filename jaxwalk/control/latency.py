"""Instruments that are told late: those of the torso and the soles, which a controller hears of over a wire.

A joint's own encoder is not among them: as in the drives of machines, the loop that it closes is local.
"""

from __future__ import annotations

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.config import DELAY_MOST
from jaxwalk.control.sensors import Estimate

Late = Float[Array, "D 6"]


def start(timestep: float, estimate: Estimate) -> Late:
    """[D, 6] what is remembered of the instruments, the newest first: ``estimate`` all the while."""
    return jnp.tile(_told(estimate), (round(DELAY_MOST / timestep) + 1, 1))


def tick(timestep: float, delay: Float[Array, ""], late: Late, estimate: Estimate) -> tuple[Late, Estimate]:
    """The memory a tick on, and ``estimate`` as it is known ``delay`` s late."""
    late = jnp.concatenate([_told(estimate)[None], late[:-1]])
    now = jnp.arange(late.shape[0]) == jnp.round(delay / timestep)
    speed, acceleration, pitch, pitch_rate, *touch = jnp.sum(jnp.where(now[:, None], late, 0.0), axis=0)
    return late, estimate.replace(
        speed=speed, acceleration=acceleration, pitch=pitch, pitch_rate=pitch_rate, touch=jnp.stack(touch)
    )


def _told(estimate: Estimate) -> Float[Array, "6"]:
    own = [estimate.speed, estimate.acceleration, estimate.pitch, estimate.pitch_rate]
    return jnp.stack([*own, *estimate.touch])
