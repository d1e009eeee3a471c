"""Walking while something is written down of every tick."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import jax
from mujoco import mjx

from jaxwalk.control.person import model_of
from jaxwalk.task import backend, stepper
from jaxwalk.task.stepper import Stepper, Task
from jaxwalk.task.trials import Act

Tick = Callable[[Task, mjx.Model, Stepper], tuple[Stepper, Any]]
"""A walker one tick further, and a pytree of arrays: what is written down of that tick. Of a module's level,
since native code is made of it once."""


@functools.cache
def watched(look: Callable[[Task, Stepper], Any]) -> Tick:
    """The plain tick, of whose outcome ``look`` is written down."""

    def tick(task: Task, model: mjx.Model, state: Stepper) -> tuple[Stepper, Any]:
        after = stepper.tick(task, model, state)
        return after, look(task, after)

    return tick


def segment(
    task: Task, act: Act, windows: int, tick: Tick, params: Any, state: Stepper
) -> tuple[Stepper, Any]:
    """One walker, ``windows`` decision windows further; the policy is asked at each one's start.

    Args:
      tick: `watched`, or one's own.

    Returns:
      The walker, and what was written down, each array with a leading axis of ticks.
    """
    ticks = task.setup.window_ticks

    def window(state: Stepper, _: None) -> tuple[Stepper, Any]:
        state = stepper.decide(state, act(params, state.observation))

        def by_xla() -> tuple[Stepper, Any]:
            model = model_of(task.setup, state.walker.person)
            return jax.lax.scan(lambda one, _: tick(task, model, one), state, length=ticks)

        return backend.scan(task.setup, _alone, (tick, task), ticks, state, otherwise=by_xla)

    state, rows = jax.lax.scan(window, state, length=windows)
    return state, jax.tree.map(lambda x: x.reshape(-1, *x.shape[2:]), rows)


def _alone(setting: tuple[Tick, Task], state: Stepper) -> tuple[Stepper, Any]:
    tick, task = setting
    return tick(task, model_of(task.setup, state.walker.person), state)
