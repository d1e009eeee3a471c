"""Walking while something is written down of every tick."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
from mujoco import mjx

from jaxwalk import stepper, walker
from jaxwalk.stepper import Stepper, Task
from jaxwalk.trials import Act

Tick = Callable[[Task, mjx.Model, Stepper], tuple[Stepper, Any]]
"""A walker one tick further, and a pytree of arrays: what is written down of that tick."""


def watched(look: Callable[[Stepper], Any]) -> Tick:
    """The plain tick, of whose outcome ``look`` is written down."""

    def tick(task: Task, model: mjx.Model, state: Stepper) -> tuple[Stepper, Any]:
        after = stepper.tick(task, model, state)
        return after, look(after)

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
    model = walker.model(task.setup, state.walker.person)

    def window(state: Stepper, _: None) -> tuple[Stepper, Any]:
        state = stepper.decide(state, act(params, state.observation))
        return jax.lax.scan(lambda one, _: tick(task, model, one), state, length=task.setup.window_ticks)

    state, rows = jax.lax.scan(window, state, length=windows)
    return state, jax.tree.map(lambda x: x.reshape(-1, *x.shape[2:]), rows)
