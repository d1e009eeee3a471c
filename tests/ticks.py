"""A walker's tick by native code, where there is any: XLA takes a minute to compile a whole walker."""

from __future__ import annotations

import functools
from typing import Any

import jax

from jaxwalk.control import walker
from jaxwalk.control.person import model_of
from jaxwalk.control.walker import Walker
from jaxwalk.model.engine import Setup
from jaxwalk.task import backend, stepper
from jaxwalk.task.stepper import Task


def alone(setup: Setup, state: Walker) -> tuple[Walker, Any]:
    """One tick of one walker, and its event."""
    return walker.tick(setup, model_of(setup, state.person), state)


def many(setup: Setup) -> Any:
    """The program of [N] walkers, a tick further each, and their events [N]."""

    def one(state: Walker) -> tuple[Walker, Any]:
        after, events = run(alone, setup, 1, state)
        return after, jax.tree.map(lambda x: x[0], events)

    return jax.jit(jax.vmap(one))


WALKERS = 1000  # of `by_xla`


@functools.cache
def by_xla(task: Task) -> Any:
    """The program of `WALKERS` steppers, a tick further each, as XLA compiles it: for whoever holds others
    against it, so that it is compiled once."""
    return jax.jit(jax.vmap(lambda state: stepper.alone(task, state)[0]))


def run(function: Any, setup: Setup, count: int, state: Walker) -> tuple[Walker, Any]:
    """``count`` ticks of one walker by ``function``, of a module's level, and what it tells of each."""

    def by_xla() -> tuple[Walker, Any]:
        return jax.lax.scan(lambda one, _: function(setup, one), state, length=count)

    return backend.scan(setup, function, setup, count, state, otherwise=by_xla)
