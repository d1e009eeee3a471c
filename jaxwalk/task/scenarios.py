"""What trials are: who is pushed, how and when, and batches of it on the configured body."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
from flax import struct
from jaxtyping import Array, Float, Int, PRNGKeyArray, UInt32

from jaxwalk.config import Config
from jaxwalk.model import pushes
from jaxwalk.model.burdens import Burden

# What keys are for.
TRAINING, ASSESS, CALM, PUSHED, TUNE, FINALS, RECORDED, DEPLOYED, REFINED = range(9)


class Scenario(struct.PyTreeNode):
    """What one trial is.

    Attributes:
      height, mass: of the walker, m, kg.
      noise: scale of its sensors' noise.
      impulse: N s, forward positive; 0 for none.
      push_ticks: how long it lasts.
      push_height: above the torso's centre, m.
      push_place: segment pushed, as in `pushes.Push`.
      phase: of the step at which it begins, 0..1.
      again: ticks after which the same push comes a second time; 0: it does not.
      key: of the start and the noise.
      burden: what it bears, untold but as `jaxwalk.model.burdens` says; None for nothing.
    """

    height: Float[Array, ""]
    mass: Float[Array, ""]
    noise: Float[Array, ""]
    impulse: Float[Array, ""]
    push_ticks: Int[Array, ""]
    push_height: Float[Array, ""]
    push_place: Int[Array, ""]
    phase: Float[Array, ""]
    again: Int[Array, ""]
    key: PRNGKeyArray
    burden: Burden | None = None


def batch(
    config: Config,
    impulse: np.ndarray,
    phase: np.ndarray,
    keys: Array,
    push_height: np.ndarray | float = 0.0,
    push_seconds: np.ndarray | float | None = None,
    push_place: np.ndarray | int = pushes.TORSO,
    burden: Burden | None = None,
    again: np.ndarray | float = 0.0,
) -> Scenario:
    """[N] scenarios.

    Args:
      impulse, phase: [N] N s and share of the step; an impulse of 0 is no push.
      keys: [N] of the starts and the noise.
      push_height: m above the torso's centre. push_seconds: default as configured.
      push_place: segment pushed, as in `pushes.Push`.
      burden: what all bear.
      again: s from the push's beginning to that of a second one like it; 0: there is none.
    """
    count = len(impulse)

    def all_of(value: np.ndarray | float) -> Array:
        return jnp.asarray(np.broadcast_to(np.asarray(value, np.float32), count))

    seconds = config.pushes.duration if push_seconds is None else push_seconds
    timestep = config.physics.timestep
    ticks = [pushes.whole_ticks(float(s), timestep) for s in np.broadcast_to(seconds, count)]
    return Scenario(
        height=all_of(config.body.height),
        mass=all_of(config.body.mass),
        noise=all_of(config.sensors.noise),
        impulse=all_of(impulse),
        push_ticks=jnp.asarray(ticks, jnp.int32),
        push_height=all_of(push_height),
        push_place=jnp.asarray(np.broadcast_to(np.asarray(push_place, np.int32), count)),
        phase=all_of(phase),
        again=jnp.asarray(np.broadcast_to(np.round(np.asarray(again) / timestep), count), jnp.int32),
        key=keys,
        burden=jax.tree.map(all_of, burden),
    )


def root(seed: int | UInt32[Array, ""], purpose: int) -> PRNGKeyArray:
    """The key that all of a purpose come from.

    To split ``jax.random.key(seed)`` itself would give the same keys as to fold purposes into it.
    """
    return jax.random.fold_in(jax.random.key(seed), purpose)


def keys(seed: int, purpose: int, count: int) -> Array:
    """[count] one key for each trial; no two purposes share any."""
    own = root(seed, purpose)
    return jax.vmap(lambda i: jax.random.fold_in(own, i))(jnp.arange(count))
