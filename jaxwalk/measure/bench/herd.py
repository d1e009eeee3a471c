"""The walkers that all batches are measured with, and how large a batch and a call of it are."""

from __future__ import annotations

import dataclasses
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.sharding import Mesh

from jaxwalk.config import Config
from jaxwalk.learn.ddpg.replay_buffer import Replay
from jaxwalk.learn.train import device_loop
from jaxwalk.learn.train.device_loop import TrainState
from jaxwalk.measure.bench.programs import record, sharded, split
from jaxwalk.measure.bench.rounds import LOOP, Builder
from jaxwalk.model import pushes
from jaxwalk.task.stepper import Stepper

_CALL = {"cpu": 2**18}  # about so many ticks of a walker a call; more on a GPU
_CALL_GPU = 2**23


def windows_of(walkers: int, config: Config) -> int:
    """Decision windows in a call: as many as training reports on, fewer of large batches."""
    ticks = _CALL.get(jax.default_backend(), _CALL_GPU) / (walkers * config.train.window_ticks)
    return max(1, min(config.train.windows_per_report, round(ticks)))


def of_size(config: Config, walkers: int) -> Config:
    """``config`` for a batch of ``walkers`` and calls of `windows_of` it."""
    train = dataclasses.replace(config.train, walkers=walkers, windows_per_report=windows_of(walkers, config))
    return dataclasses.replace(config, train=train)


class Herd:
    """The walkers of all batches: those of the smallest one, in mid-step, over again.

    They have walked as training's first ones do, pushed and exploring, until the learner learned.

    Args:
      config: of the smallest batch.
    """

    def __init__(self, config: Config, mesh: Mesh, seed: int, builder: Builder) -> None:
        self.config, self.mesh, self.count, self.seed = config, mesh, config.train.walkers, seed
        state = device_loop.init(config, mesh, seed)
        self.loop = builder.build(LOOP, device_loop.make(config, mesh), state)
        while float(state.learner.updates) == 0:
            state = self.loop[0](state)
        self.state: TrainState = state
        task = device_loop.task_of(config)
        ticks = config.train.windows_per_report * config.train.window_ticks
        self.commands = sharded(partial(record, task, ticks), mesh)(self.unpushed(self.count))

    def of(self, walkers: int) -> TrainState:
        """Training in a batch of so many, nothing of it shared with another."""
        state = jax.tree.map(jnp.copy, self.state.replace(steppers=None, replay=None, exploration=None))
        return state.replace(
            steppers=split(self._again(self.state.steppers, walkers), self.mesh),
            replay=split(dealt(self.state.replay, walkers), self.mesh),
            exploration=split(self._again(self.state.exploration, walkers), self.mesh),
        )

    def unpushed(self, walkers: int) -> Stepper:
        """So many, whom nobody pushes."""
        states = self._again(self.state.steppers, walkers)
        calm = jax.tree.map(lambda none, x: jnp.full_like(x, none), pushes.none(), states.walker.push)
        return split(states.replace(walker=states.walker.replace(push=calm)), self.mesh)

    def followed(self, walkers: int, ticks: int) -> Any:
        """[B, ticks, 6] the commands that the unpushed follow at their nominal step."""
        return split(self._again(self.commands, walkers)[:, :ticks], self.mesh)

    def _again(self, tree: Any, walkers: int) -> Any:
        index = np.resize(np.arange(self.count), walkers)
        return jax.tree.map(lambda x: x[index], tree)


def dealt(memory: Replay, walkers: int) -> Replay:
    """``memory`` for another number of walkers: each has the first rows of a ring, some the same."""
    old = memory.size.shape[0]
    capacity = max(1, memory.capacity * old // walkers)
    ring, slot = np.resize(np.arange(old), walkers)[:, None], np.arange(capacity) % memory.capacity
    filled = jnp.minimum(memory.size[ring[:, 0]], capacity)
    return Replay(jax.tree.map(lambda x: x[ring, slot], memory.rows), filled % capacity, filled)
