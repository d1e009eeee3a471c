"""The circumstance that a walker of training draws for its life: domain randomisation, one thing at a time.

So a policy meets each of those that it is measured by (`jaxwalk generalise`), late instruments together with
weak motors, while the other walkers walk as configured.
"""

from __future__ import annotations

import math
from typing import Any

import jax
import jax.numpy as jnp
from flax import struct
from jaxtyping import Array, Float, PRNGKeyArray

from jaxwalk.config import Config
from jaxwalk.model.burdens import BACKPACK, FRONT_PACK, Burden

KINDS = ("speed", "backpack", "front_pack", "slope", "friction", "noise", "late")


class Drawn(struct.PyTreeNode):
    """What one walker meets.

    Attributes:
      speed: asked for, m/s. noise: scale of its sensors' noise.
      burden: what it bears, told of its delay alone; None where nobody bears anything.
    """

    speed: Float[Array, ""]
    noise: Float[Array, ""]
    burden: Burden | None = None


def draw(config: Config, key: PRNGKeyArray) -> Drawn:
    """A walker's circumstance: none for 1 - `share` of them, else one of `KINDS`, the last `late` times as
    often as another."""
    own, usual = config.circumstances, jnp.float32(config.gait.speed_desired)
    if not own.share:
        return Drawn(usual, jnp.float32(config.sensors.noise))
    meets_key, kind_key, size_key = jax.random.split(key, 3)
    kind = jnp.minimum(jax.random.randint(kind_key, (), 0, len(KINDS) + own.late - 1), len(KINDS) - 1)
    kind = jnp.where(jax.random.uniform(meets_key) < own.share, kind, len(KINDS))
    size = jax.random.uniform(size_key)
    either, size = 2.0 * size - 1.0, jnp.sqrt(size)  # the hard ones more often: near 0 all walk as usual

    def of(name: str, value: Any, otherwise: Any) -> Float[Array, ""]:
        return jnp.where(kind == KINDS.index(name), value, otherwise)

    back = kind == KINDS.index("backpack")
    ahead, up = (
        jnp.where(back, *map(jnp.float32, places)) for places in zip(BACKPACK, FRONT_PACK, strict=True)
    )
    pack = own.pack * size
    friction = config.physics.friction
    limited = config.physics.actuators != "unlimited"
    burden = Burden(
        mass=of("backpack", pack, of("front_pack", pack, 0.0)),
        ahead=ahead,
        up=up,
        force=jnp.zeros(()),
        friction=of("friction", friction + (own.friction - friction) * size, friction),
        slope=of("slope", math.radians(own.slope) * either, 0.0),
        strength=of("late", 1.0 + (own.strength - 1.0) * size if limited else 1.0, 1.0),
        delay=of("late", own.delay * size, 0.0),
    )
    noise = config.sensors.noise * of("noise", 1.0 + (own.noise - 1.0) * size, 1.0)
    return Drawn(of("speed", usual + own.speed * either, usual), noise, burden)
