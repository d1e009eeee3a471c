"""Whom training meets: new walkers, and the pushes that they are dealt."""

from __future__ import annotations

from functools import partial

import jax
import jax.numpy as jnp
from jaxtyping import Array, Key, PRNGKeyArray

from jaxwalk.common.parallel import devices
from jaxwalk.config import Config
from jaxwalk.model import pushes
from jaxwalk.task import stepper
from jaxwalk.task.stepper import Stepper, Task


def walker(config: Config, task: Task, key: PRNGKeyArray) -> Stepper:
    """A new walker as training meets them: its own stature, mass and first push."""
    height_key, mass_key, start_key, push_key = jax.random.split(key, 4)
    stature = 1 + config.train.height_spread * jax.random.uniform(height_key, (), minval=-1.0)
    build = 1 + config.train.mass_spread * jax.random.uniform(mass_key, (), minval=-1.0)
    height = config.body.height * stature
    mass = config.body.mass * stature**3 * build  # people of one shape weigh with the cube
    fresh = stepper.start(task, config.gait, height, mass, jnp.float32(config.sensors.noise), start_key)
    return fresh.replace(walker=fresh.walker.replace(push=push(config, fresh, push_key)))


def push(config: Config, state: Stepper, key: PRNGKeyArray) -> pushes.Push:
    """The next push of a walker: exponential waiting time, random direction, size and height."""
    wait_key, side_key, size_key, height_key = jax.random.split(key, 4)
    settings = config.pushes
    wait = jax.random.exponential(wait_key) / settings.rate if settings.rate else jnp.inf
    ratio = state.walker.person.ratio
    forward = jax.random.bernoulli(side_key)
    most = jnp.where(forward, settings.impulse_forward, -settings.impulse_backward)
    share = jax.random.uniform(size_key, (), minval=settings.impulse_least, maxval=1.0)
    impulse = most * share * ratio.impulse
    height = settings.height_spread * jax.random.uniform(height_key, (), minval=-1.0) * ratio.length
    ticks = jnp.minimum(wait / config.physics.timestep, 1e8).astype(jnp.int32)
    begin = state.walker.tick + ticks
    return pushes.of_impulse(impulse, begin, settings.duration, config.physics.timestep, height)


def renew(config: Config, task: Task, states: Stepper, keys: Key[Array, " B"]) -> Stepper:
    """Between windows: of B walkers, whoever is done starts anew, whoever's push is over gets the next.

    Args:
      keys: [B], each walker's own.
    """
    push_keys, spawn_keys = jnp.unstack(jax.vmap(jax.random.split)(keys), axis=1)

    def pushed(state: Stepper, key: PRNGKeyArray) -> Stepper:
        old = state.walker.push
        over = state.walker.tick >= old.start + old.ticks
        new = stepper.select(over, push(config, state, key), old)
        return state.replace(walker=state.walker.replace(push=new))

    def anew(states: Stepper) -> Stepper:
        fresh = jax.vmap(partial(walker, config, task))(spawn_keys)
        return jax.vmap(stepper.select)(states.done, fresh, states)

    states = jax.vmap(pushed)(states, push_keys)
    # In most windows nobody is done.
    return jax.lax.cond(devices.anywhere(jnp.any(states.done)), anew, lambda same: same, states)
