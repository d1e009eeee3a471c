"""Candidates of an evolution strategy: policies as vectors of numbers, each with walkers of its own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree
from jax.sharding import Mesh
from jaxtyping import Array, Float, PRNGKeyArray

from jaxwalk.common.parallel import devices
from jaxwalk.config import Config
from jaxwalk.learn.ddpg import networks
from jaxwalk.task import collect, footstep, rules, scenarios, spawn
from jaxwalk.task.stepper import Stepper, Task

SEEN_SECONDS = 10.0  # that the first policy walks, for the observations' mean and spread


@dataclass(frozen=True)
class Shape:
    """What a candidate's numbers stand for.

    Attributes:
      hidden: widths of the network's layers.
      first: [n] the numbers of the policy that answers as nothing learned does, everywhere.
      unravel: from [n] numbers to the parameters of `networks.Actor`.
      mean, std: [O] of observations.
    """

    hidden: tuple[int, ...]
    first: Float[Array, "n"]
    unravel: Callable[[Float[Array, "n"]], networks.Params]
    mean: Float[Array, "O"]
    std: Float[Array, "O"]

    def act(self, numbers: Float[Array, "n"], observation: Float[Array, "O"]) -> Float[Array, "2"]:
        """One candidate's action for one raw observation."""
        actor = networks.Actor(self.hidden, len(footstep.ACTIONS))
        return networks.applied(actor, self.unravel(numbers), (observation - self.mean) / self.std)


def shape(config: Config, seed: int) -> Shape:
    """The kind of candidates that a search of ``config`` begins with."""
    key = scenarios.root(seed, scenarios.TRAINING)
    network_key, walk_key = jax.random.split(key)
    nominal = rules.nominal(config)
    told = networks.init_actor(
        config.ddpg.hidden, network_key, len(config.observation), np.asarray(nominal).tolist()
    )
    output = {**told["output"], "kernel": jnp.zeros_like(told["output"]["kernel"])}
    first, unravel = ravel_pytree({**told, "output": output})
    mean, std = _seen(config, nominal, walk_key)
    return Shape(config.ddpg.hidden, first, unravel, mean, std)


def _seen(
    config: Config, action: Float[Array, "2"], key: PRNGKeyArray
) -> tuple[Float[Array, "O"], Float[Array, "O"]]:
    """Mean and spread of what walkers see who answer ``action``, pushed as in training."""
    task, count = Task.of(config), config.train.walkers
    windows = round(SEEN_SECONDS / config.physics.timestep / config.train.window_ticks)

    def act(observation: Float[Array, "B O"], keys: Any) -> Float[Array, "B 2"]:
        return jnp.broadcast_to(action, (count, len(action)))

    def on(states: Stepper, key: PRNGKeyArray) -> tuple[Stepper, Float[Array, "B O"]]:
        states, _ = collect.window(config, task, states, act, jax.random.split(key, count))
        return states, states.observation

    @jax.jit
    def walk(key: PRNGKeyArray) -> Float[Array, "W B O"]:
        begin, keys = jax.random.split(key)
        states = jax.vmap(partial(spawn.walker, config, task))(jax.random.split(begin, count))
        return jax.lax.scan(on, states, jax.random.split(keys, windows))[1]

    seen = walk(key)
    return jnp.mean(seen, (0, 1)), jnp.std(seen, (0, 1)) + 1e-6


def earning(config: Config, kind: Shape, mesh: Mesh) -> Callable[[Any, PRNGKeyArray], np.ndarray]:
    """The program ([K, n] candidates, key) -> [K, 2]: what each earns in the time of a nominal step, and its
    footsteps.

    A candidate's walkers are those that training meets (`spawn`), pushed again and again and begun anew when
    they fall; all candidates have the same ones, with the same noise.
    """
    task, own = Task.of(config), config.es
    windows = round(own.seconds / config.physics.timestep / config.train.window_ticks)
    steps = own.seconds / config.gait.duration_nominal

    def lives(key: PRNGKeyArray, numbers: Float[Array, "K n"]) -> Float[Array, "K 2"]:
        count = numbers.shape[0]

        def alike(key: PRNGKeyArray) -> Array:
            return jnp.tile(jax.random.split(key, own.walkers), count)

        def act(observation: Float[Array, "B O"], _: Any) -> Float[Array, "B 2"]:
            seen = observation.reshape(count, own.walkers, -1)
            actions = jax.vmap(lambda n, o: jax.vmap(partial(kind.act, n))(o))(numbers, seen)
            return actions.reshape(count * own.walkers, -1)

        def on(carry: tuple[Stepper, Array], key: PRNGKeyArray) -> tuple[tuple[Stepper, Array], None]:
            states, sums = carry
            states, brought = collect.window(config, task, states, act, alike(key))
            told = jnp.where(brought.footsteps.closed, brought.footsteps.transition.reward, 0.0)
            more = jnp.stack([told, brought.landed.astype(jnp.float32)], axis=-1)
            return (states, sums + more), None

        begin, keys = jax.random.split(key)
        states = jax.vmap(partial(spawn.walker, config, task))(alike(begin))
        zero = jnp.zeros((count * own.walkers, 2))
        sums = jax.lax.scan(on, (states, zero), jax.random.split(keys, windows))[0][1]
        earned, landed = jnp.moveaxis(sums.reshape(count, own.walkers, 2), -1, 0)
        return jnp.stack([jnp.mean(earned, axis=1) / steps, jnp.sum(landed, axis=1)], axis=-1)

    program = devices.spread(lives, mesh, (False, True))
    return lambda numbers, key: np.asarray(program(key, jnp.asarray(numbers, jnp.float32)))
