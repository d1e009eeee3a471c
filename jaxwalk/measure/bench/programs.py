"""What the benchmark's walkers go through: one motion, by the whole tick or by ``mjx.step`` alone."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.sharding import Mesh, NamedSharding, PartitionSpec
from jaxtyping import Array, Bool, Float
from mujoco import mjx

from jaxwalk.common.errors import UserError
from jaxwalk.common.parallel import devices
from jaxwalk.common.parallel.devices import AXIS
from jaxwalk.config import Config
from jaxwalk.control import walker
from jaxwalk.control.person import model_of
from jaxwalk.control.walker import Walker
from jaxwalk.model import physics, pushes
from jaxwalk.task import collect, footstep, spawn, stepper
from jaxwalk.task.stepper import Stepper, Task


def walk_ticks(task: Task, count: int, state: Stepper) -> tuple[Stepper, Float[Array, ""]]:
    """One walker, ``count`` windows at its nominal step, without a policy; and its footsteps."""

    def window(state: Stepper, _: None) -> tuple[Stepper, Bool[Array, ""]]:
        state = stepper.decide(state, footstep.nominal_action(state.walker.person))
        state = collect.run_ticks(task, state, task.setup.window_ticks)
        return state, collect.landed(task, state)

    state, landed = jax.lax.scan(window, state, length=count)
    return state, jnp.sum(landed, dtype=jnp.float32)


def record(task: Task, ticks: int, state: Stepper) -> Float[Array, "T 6"]:
    """The commands that `walk_ticks` gives to the joints, tick by tick."""
    setup = task.setup
    model = model_of(setup, state.walker.person)

    def tick(state: Stepper, _: None) -> tuple[Stepper, Float[Array, "6"]]:
        body = state.walker
        command = walker.command(setup, body)
        state = stepper.decide(state, footstep.nominal_action(body.person))
        return stepper.tick(task, model, state), command

    return jax.lax.scan(tick, state, length=ticks)[1]


def bare_steps(config: Config, task: Task, body: Walker, commands: Float[Array, "T 6"]) -> mjx.Data:
    """One walker, the same ticks as users of MJX write them: ``mjx.step`` on the whole of its data."""
    model = model_of(task.setup, body.person)
    data = mjx.make_data(physics.compile_mujoco(config.body, config.physics), impl="jax")
    plant, where = body.plant, physics.layout(config.body)
    data = data.replace(qpos=plant.qpos, qvel=plant.qvel, qacc_warmstart=plant.warmstart)

    def step(data: mjx.Data, command: Float[Array, "6"]) -> tuple[mjx.Data, None]:
        return mjx.step(model, data.replace(ctrl=where.control(command))), None

    return jax.lax.scan(step, data, commands)[0]


def unpushed(config: Config, task: Task, key: Array) -> Stepper:
    """A walker as training starts them, but that nobody pushes."""
    state = spawn.walker(config, task, key)
    return state.replace(walker=state.walker.replace(push=pushes.none()))


def standing(states: Stepper) -> Stepper:
    """Those who fell on the way are replaced by others who did not: a heap is no walk."""
    up = np.flatnonzero(~np.asarray(states.terminated))
    if not up.size:
        raise UserError("bench: no walker stands, the configured gait does not walk")
    index = np.resize(up, states.asked.shape[0])
    return jax.tree.map(lambda x: x[index], states)


def sharded(function: Callable[..., Any], mesh: Mesh) -> Any:
    """``function`` of one walker, compiled for many, split over all of ``mesh``."""
    rows = PartitionSpec(AXIS)
    mapped = jax.shard_map(
        partial(devices.each, function), mesh=mesh, in_specs=rows, out_specs=rows, check_vma=False
    )
    return jax.jit(mapped)


def split(tree: Any, mesh: Mesh) -> Any:
    """Arrays with a leading axis of walkers, put where `sharded` computes on them."""
    return jax.device_put(tree, NamedSharding(mesh, PartitionSpec(AXIS)))
