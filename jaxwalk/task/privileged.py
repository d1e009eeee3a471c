"""What a critic is told besides, in training alone: the body, what it bears, and the push that is to come.

No policy is told of these, and none needs its critic once it is trained: so the critic may know all that
the simulation does (an asymmetric actor-critic: Pinto et al. 2018). What a return owes to a pack on the back
or to the push that came is then no noise in what it owes to an answer.
"""

from __future__ import annotations

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.control.walker import Walker
from jaxwalk.model.burdens import Burden
from jaxwalk.model.engine import Setup

COUNT = 12
_PAST, _AHEAD = 1.0, 2.0  # s: of pushes over longer ago, or further ahead, is only told that they are


def told(setup: Setup, state: Walker) -> Float[Array, "12"]:
    """Stature, build, noise; mass and moment of the pack, slope, friction, motors, delay; the push.

    Of the push, when it begins, from now on, its impulse and its height; in the reference body's units where
    these scale (m, kg, rad, s, N s).
    """
    person, push = state.person, state.push
    ratio = person.ratio
    burden = person.burden or Burden(0.0, 0.0, 0.0, 0.0, setup.physics.friction)
    until = (push.start - state.tick).astype(jnp.float32) * setup.timestep
    numbers = (
        ratio.length,
        ratio.mass / ratio.length**3,
        state.sensors.noise,
        burden.mass / ratio.mass,
        burden.mass * burden.ahead / (ratio.mass * ratio.length),
        burden.slope,
        burden.friction,
        burden.strength,
        burden.delay,
        jnp.clip(until, -_PAST, _AHEAD),
        push.force * push.ticks * setup.timestep / ratio.impulse,
        push.height / ratio.length,
    )
    return jnp.stack([jnp.asarray(x, jnp.float32) for x in numbers])
