"""Windowed collection: many steppers advance together, a fixed number of ticks at a time.

Walkers touch down at different ticks; waiting for the slowest would waste the others.
So ticks run in windows, and the policy is asked once for all at each window's start; a
touch-down inside a window is answered at its end, before early swing needs the answer.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import jax
import jax.numpy as jnp
from flax import struct
from jaxtyping import Array, Bool, Float, Key, PRNGKeyArray

from jaxwalk import stepper, stepping
from jaxwalk.common.errors import UserError
from jaxwalk.common.parallel import devices
from jaxwalk.config import REFERENCE_HEIGHT, Config, GaitConfig
from jaxwalk.control import walker
from jaxwalk.control.person import model_of
from jaxwalk.model import pushes
from jaxwalk.stepper import Footsteps, Stepper, Task

Act = Callable[[Float[Array, "B O"], Key[Array, " B"]], Float[Array, "B 2"]]


@struct.dataclass
class Window:
    """What one window brought, for each of B walkers.

    Attributes:
      footsteps: [B] those that closed.
      fell, truncated, broken: [B] episodes that ended, and how.
    """

    footsteps: Footsteps
    fell: Bool[Array, "B"]
    truncated: Bool[Array, "B"]
    broken: Bool[Array, "B"]


def shortest_toe_off(numbers: GaitConfig, height: float) -> float:
    """s, for a body of ``height`` times the reference body's."""
    return numbers.toe_off_duration_min * height**0.5


def check(config: Config) -> None:
    """Refuse a window that could miss a touch-down or answer one too late.

    Raises:
      UserError: the window is longer than the shortest walker's toe-off.
    """
    shortest = min(1.0, config.body.height * (1 - config.train.height_spread) / REFERENCE_HEIGHT)
    toe_off = shortest_toe_off(config.gait, shortest)
    seconds = config.train.window_ticks * config.physics.timestep
    if seconds > toe_off:
        raise UserError(
            f"train.window_ticks {config.train.window_ticks} last {seconds:.3f} s, "
            f"longer than the shortest toe-off, {toe_off:.3f} s: "
            f"give at most {int(toe_off / config.physics.timestep)}"
        )


def spawn(config: Config, task: Task, key: PRNGKeyArray) -> Stepper:
    """A new walker as training meets them: its own stature, mass and first push."""
    height_key, mass_key, start_key, push_key = jax.random.split(key, 4)
    stature = 1 + config.train.height_spread * jax.random.uniform(height_key, (), minval=-1.0)
    build = 1 + config.train.mass_spread * jax.random.uniform(mass_key, (), minval=-1.0)
    height = config.body.height * stature
    mass = config.body.mass * stature**3 * build  # people of one shape weigh with the cube
    fresh = stepper.start(task, config.gait, height, mass, jnp.float32(config.sensors.noise), start_key)
    return fresh.replace(walker=fresh.walker.replace(push=draw_push(config, fresh, push_key)))


def draw_push(config: Config, state: Stepper, key: PRNGKeyArray) -> pushes.Push:
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
        push = state.walker.push
        over = state.walker.tick >= push.start + push.ticks
        push = stepper.select(over, draw_push(config, state, key), push)
        return state.replace(walker=state.walker.replace(push=push))

    def anew(states: Stepper) -> Stepper:
        fresh = jax.vmap(partial(spawn, config, task))(spawn_keys)
        return jax.vmap(stepper.select)(states.done, fresh, states)

    states = jax.vmap(pushed)(states, push_keys)
    # In most windows nobody is done.
    return jax.lax.cond(devices.anywhere(jnp.any(states.done)), anew, lambda same: same, states)


def run_ticks(task: Task, state: Stepper, ticks: int) -> Stepper:
    """One walker, ``ticks`` physics steps; its last closed footstep is in ``last``."""
    state = state.replace(last=state.last.replace(closed=jnp.bool_(False)))

    def by_xla() -> tuple[Stepper, None]:
        model, white = model_of(task.setup, state.walker.person), walker.noise(state.walker, ticks)
        return jax.lax.fori_loop(0, ticks, lambda i, s: stepper.tick(task, model, s, white[i]), state), None

    return stepping.scan(task.setup, stepper.alone, task, ticks, state, otherwise=by_xla)[0]


def window(
    config: Config, task: Task, states: Stepper, act: Act, keys: Key[Array, " B"]
) -> tuple[Stepper, Window]:
    """All B walkers: decide, run the window's ticks, renew those that are done.

    Args:
      states: Stepper with leading axis B.
      act: from [B, O] observations and [B] keys to [B, 2] actions in [-1, 1].
      keys: [B], each walker's own: what is drawn for one does not depend on how many others there are.
    """
    act_keys, renew_keys = jnp.unstack(jax.vmap(jax.random.split)(keys), axis=1)
    actions = act(states.observation, act_keys)
    states = jax.vmap(stepper.decide)(states, actions)
    states = stepping.each(task.setup, lambda s: run_ticks(task, s, config.train.window_ticks), states)
    brought = Window(states.last, states.terminated, states.truncated, states.broken)
    return renew(config, task, states, renew_keys), brought
