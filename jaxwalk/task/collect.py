"""Windowed collection: many steppers advance together, a fixed number of ticks at a time.

Walkers touch down at different ticks; waiting for the slowest would waste the others.
So ticks run in windows, and the policy is asked once for all at each window's start; a
touch-down inside a window is answered at its end: rigid legs' early swing needs the answer no sooner, and
compliant ones may be told otherwise at any time.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import jax
import jax.numpy as jnp
from flax import struct
from jaxtyping import Array, Bool, Float, Int, Key

from jaxwalk.common.errors import UserError
from jaxwalk.config import REFERENCE_HEIGHT, Config, GaitConfig
from jaxwalk.control import walker
from jaxwalk.control.person import model_of
from jaxwalk.task import backend, course, spawn, stepper
from jaxwalk.task.stepper import Footstep, Stepper, Task

Act = Callable[[Float[Array, "B O"], Key[Array, " B"]], Float[Array, "B 2"]]


class Window(struct.PyTreeNode):
    """What one window brought, for each of B walkers.

    Attributes:
      footsteps: [B] those that closed; of steps that are decided anew, what was decided last.
      landed: [B] those of them that ended in a touch-down or a fall, and not amid the step.
      fell, truncated, broken: [B] episodes that ended, and how.
      dealt: [B] the cells (`course`) of pushes that were drawn after it, and lost: of those that were fallen
        over in it; -1: none.
    """

    footsteps: Footstep
    landed: Bool[Array, "B"]
    fell: Bool[Array, "B"]
    truncated: Bool[Array, "B"]
    broken: Bool[Array, "B"]
    dealt: Int[Array, "B"]
    lost: Int[Array, "B"]


def shortest_toe_off(numbers: GaitConfig, ratio: float) -> float:
    """The shortest time, s, in which an answer is awaited, of a body of ``ratio`` times the reference body's
    stature: rigid legs' toe-off; the shortest step of compliant ones, which can be changed at any time."""
    shortest = numbers.toe_off_duration_min if numbers.form == "rigid" else numbers.duration_min
    return shortest * ratio**0.5


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


def run_ticks(task: Task, state: Stepper, ticks: int) -> Stepper:
    """One walker, ``ticks`` physics steps; its last closed footstep is in ``last``."""
    state = state.replace(last=state.last.replace(closed=jnp.bool_(False)))

    def by_xla() -> tuple[Stepper, None]:
        model, white = model_of(task.setup, state.walker.person), walker.noise(state.walker, ticks)
        return jax.lax.fori_loop(0, ticks, lambda i, s: stepper.tick(task, model, s, white[i]), state), None

    return backend.scan(task.setup, stepper.alone, task, ticks, state, otherwise=by_xla)[0]


def landed(task: Task, state: Stepper) -> Bool[Array, ""]:
    """Whether the footstep that closed in the window just run ended in a touch-down or a fall."""
    whole = (task.setup.window_ticks - 0.5) * task.setup.timestep
    return state.last.closed & (state.terminated | (state.walker.gait.elapsed < whole))


def window(
    config: Config,
    task: Task,
    states: Stepper,
    act: Act,
    keys: Key[Array, " B"],
    shares: spawn.Shares = None,
) -> tuple[Stepper, Window]:
    """All B walkers: decide, run the window's ticks, renew those that are done.

    Args:
      states: Stepper with leading axis B.
      act: from [B, O] observations and [B] keys to [B, 2] actions in [-1, 1].
      keys: [B], each walker's own: what is drawn for one does not depend on how many others there are.
      shares: as for `spawn.push`.
    """
    act_keys, renew_keys = jnp.unstack(jax.vmap(jax.random.split)(keys), axis=1)
    actions = act(states.observation, act_keys)
    states = jax.vmap(stepper.decide)(states, actions)
    states = backend.each(task.setup, lambda s: run_ticks(task, s, config.train.window_ticks), states)
    ended = jax.vmap(partial(landed, task))(states)
    begun = states.walker.tick >= states.walker.push.start
    blamed = jnp.where(begun, states.walker.push.cell, states.walker.push.before)
    renewed = spawn.renew(config, task, states, renew_keys, shares)
    fresh = (renewed.walker.push.start != states.walker.push.start) | states.done
    brought = Window(
        footsteps=states.last,
        landed=ended,
        fell=states.terminated,
        truncated=states.truncated,
        broken=states.broken,
        dealt=jnp.where(fresh, renewed.walker.push.cell, course.NONE),
        lost=jnp.where(states.terminated, blamed, course.NONE),
    )
    return renewed, brought
