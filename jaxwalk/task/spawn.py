"""Whom training meets: new walkers, and the pushes that they are dealt."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Key, PRNGKeyArray

from jaxwalk.common.parallel import devices
from jaxwalk.config import Config
from jaxwalk.model import pushes
from jaxwalk.task import circumstances, course, stepper
from jaxwalk.task.stepper import Stepper, Task

Shares = Float[Array, "S P"] | None
SHORTEST, USUAL = 0.2, 0.6  # s of a step that is one; of the reference body's, before it has taken any
SOON = (0.5, 1.5)  # s after another push, of one that comes without a rest


def walker(config: Config, task: Task, key: PRNGKeyArray, shares: Shares = None) -> Stepper:
    """A new walker as training meets them: its own stature, mass, circumstance and first push."""
    height_key, mass_key, start_key, push_key, met_key = jax.random.split(key, 5)
    stature = 1 + config.train.height_spread * jax.random.uniform(height_key, (), minval=-1.0)
    build = 1 + config.train.mass_spread * jax.random.uniform(mass_key, (), minval=-1.0)
    height = config.body.height * stature
    mass = config.body.mass * stature**3 * build  # people of one shape weigh with the cube
    met = circumstances.draw(config, met_key)
    numbers = dataclasses.replace(config.gait, speed_desired=met.speed)
    fresh = stepper.start(task, numbers, height, mass, met.noise, start_key, met.burden)
    return fresh.replace(walker=fresh.walker.replace(push=push(config, fresh, push_key, shares)))


def push(config: Config, state: Stepper, key: PRNGKeyArray, shares: Shares = None) -> pushes.Push:
    """The next push of a walker: after a rest and an exponential waiting time, or soon after the last one;
    of random side, size, phase of the step, and height.

    Args:
      shares: of the cells of `course`; all alike if not given.
    """
    wait_key, soon_key, cell_key, height_key = jax.random.split(key, 4)
    settings, body = config.pushes, state.walker
    ratio, burden = body.person.ratio, body.person.burden
    late = course.USUAL if burden is None else jnp.where(burden.delay > 0, course.LATE, course.USUAL)
    soon = (body.tick > 0) & (jax.random.uniform(soon_key) < settings.soon)
    dealt = course.draw(
        jnp.asarray(course.even()) if shares is None else shares,
        jnp.where(soon, course.SOON, late),
        cell_key,
    )
    wait = settings.rest + jax.random.exponential(wait_key) / settings.rate if settings.rate else jnp.inf
    wait = jnp.where(soon, jax.random.uniform(wait_key, (), minval=SOON[0], maxval=SOON[1]), wait)
    most = jnp.where(dealt.forward, settings.impulse_forward, -settings.impulse_backward)
    impulse = most * (settings.impulse_least + (1 - settings.impulse_least) * dealt.size) * ratio.impulse
    height = settings.height_spread * jax.random.uniform(height_key, (), minval=-1.0) * ratio.length
    # Of steps as long as the last one.
    step = jnp.where(state.last.seconds > SHORTEST, state.last.seconds, USUAL * ratio.time)
    wait = jnp.mod(dealt.phase * step - body.gait.elapsed, step) + jnp.floor(wait / step) * step
    begin = body.tick + jnp.minimum(wait / config.physics.timestep, 1e8).astype(jnp.int32)
    next_one = pushes.of_impulse(impulse, begin, settings.duration, config.physics.timestep, height)
    return next_one.replace(cell=dealt.cell, before=body.push.cell)


def renew(
    config: Config, task: Task, states: Stepper, keys: Key[Array, " B"], shares: Shares = None
) -> Stepper:
    """Between windows: of B walkers, whoever is done starts anew, whoever's push is over gets the next.

    Args:
      keys: [B], each walker's own.
      shares: as for `push`.
    """
    push_keys, spawn_keys = jnp.unstack(jax.vmap(jax.random.split)(keys), axis=1)

    def pushed(state: Stepper, key: PRNGKeyArray) -> Stepper:
        old = state.walker.push
        over = state.walker.tick >= old.start + old.ticks
        new = stepper.select(over, push(config, state, key, shares), old)
        return state.replace(walker=state.walker.replace(push=new))

    def anew(states: Stepper) -> Stepper:
        fresh = jax.vmap(lambda key: walker(config, task, key, shares))(spawn_keys)
        return jax.vmap(stepper.select)(states.done, fresh, states)

    states = jax.vmap(pushed)(states, push_keys)
    # In most windows nobody is done.
    return jax.lax.cond(devices.anywhere(jnp.any(states.done)), anew, lambda same: same, states)
