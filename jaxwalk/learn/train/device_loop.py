"""The training loop that stays on the device: collect a window, remember it, learn from memory.

Walkers and replay are split over the devices of a mesh, the learner is replicated and its
gradients are averaged; on a CPU the devices are its cores. Nothing that is drawn depends on how many
there are: walkers have keys of their own, and batches are drawn from as many `blocks` of them. What
remains is rounding, for sums are ordered otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from flax import struct
from jax.sharding import Mesh, NamedSharding, PartitionSpec
from jaxtyping import Array, Float, Int, Key, PRNGKeyArray

from jaxwalk.common.parallel import collectives
from jaxwalk.common.parallel.devices import AXIS
from jaxwalk.config import Config
from jaxwalk.control.person import Person
from jaxwalk.learn.ddpg import learner, noise, replay_buffer
from jaxwalk.learn.ddpg.learner import LearnerState
from jaxwalk.learn.ddpg.replay_buffer import Replay
from jaxwalk.task import collect, course, footstep, privileged, scenarios, spawn
from jaxwalk.task.course import Course
from jaxwalk.task.stepper import Stepper, Task

RETURN_STEPS, RETURNS, RETURN_SPACING = 100, 16, 20
"""Decisions that a return is followed for; how many are told of each walker, so many decisions apart."""


class Counts(struct.PyTreeNode):
    """Sums since the last report, equal on all devices.

    Attributes:
      footsteps: landed. falls, truncations: episodes that ended so. broken: those of the falls
        that a number that is not finite ended.
      reward: sum over all that was decided. speed, length, seconds: over footsteps (m/s, m, s).
    """

    footsteps: Float[Array, ""]
    falls: Float[Array, ""]
    truncations: Float[Array, ""]
    broken: Float[Array, ""]
    reward: Float[Array, ""]
    speed: Float[Array, ""]
    length: Float[Array, ""]
    seconds: Float[Array, ""]


class TrainState(struct.PyTreeNode):
    """Everything that training changes. W walkers and their replay are sharded, the rest is replicated.

    Attributes:
      steppers: [W] walkers in mid-step.
      replay: [W] rings, one for each.
      learner: networks, optimisers, statistics.
      counts: since the last report.
      course: what came of the pushes.
      footsteps: gathered in all; each may hold many decisions.
      owed: updates due, fractions included.
      key: of exploration, renewals and sampling.
      exploration: [W, A] noise under way, of unit variance.
    """

    steppers: Stepper
    replay: Replay
    learner: LearnerState
    counts: Counts
    course: Course
    footsteps: Float[Array, ""]
    owed: Float[Array, ""]
    key: PRNGKeyArray
    exploration: Float[Array, "W A"]


def _no_counts() -> Counts:
    return Counts(*[jnp.zeros(())] * 8)


def _specs() -> TrainState:
    split, same = PartitionSpec(AXIS), PartitionSpec()
    specs: list[Any] = [split, split, same, same, same, same, same, same, split]  # in the places of arrays
    return TrainState(*specs)


def blocks(config: Config) -> int:
    """R: walkers and batch are split evenly over so many blocks, and these over the devices."""
    return math.gcd(config.train.walkers, config.ddpg.batch_size)


def init(config: Config, mesh: Mesh, seed: int) -> TrainState:
    """A run at its start, laid out over the mesh, whose devices must divide `blocks`."""
    program = _initial(config, mesh)
    collectives.barrier()  # compiled, or one that has to would keep the others waiting amid the program
    return program(np.uint32(seed))


@cache
def _initial(config: Config, mesh: Mesh) -> Callable[[Any], TrainState]:
    return jax.jit(_build(config), out_shardings=shardings(mesh)).lower(np.uint32(0)).compile()


def layout(config: Config) -> TrainState:
    """What ``init`` gives, types and shapes only."""
    return jax.eval_shape(_build(config), np.uint32(0))


def shardings(mesh: Mesh) -> TrainState:
    """How the parts of a ``TrainState`` lie on the mesh."""
    return jax.tree.map(
        lambda spec: NamedSharding(mesh, spec), _specs(), is_leaf=lambda x: isinstance(x, PartitionSpec)
    )


def _build(config: Config) -> Callable[[Any], TrainState]:
    task, count = task_of(config), config.train.walkers
    besides = privileged.COUNT if task.privileged else 0

    def build(seed: Any) -> TrainState:
        walkers_key, learner_key, key = jax.random.split(scenarios.root(seed, scenarios.TRAINING), 3)
        keys = jax.random.split(walkers_key, config.train.walkers)
        steppers = jax.vmap(partial(spawn.walker, config, task))(keys)
        capacity = max(1, config.ddpg.replay_capacity // count)
        example = jax.tree.map(lambda x: x[0], steppers.last.transition)
        return TrainState(
            steppers=steppers,
            replay=replay_buffer.init(count, capacity, example),
            learner=learner.init(
                config.ddpg, learner_key, len(config.observation), _initial_action(config), besides
            ),
            counts=_no_counts(),
            course=course.start(),
            footsteps=jnp.zeros(()),
            owed=jnp.zeros(()),
            key=key,
            exploration=jnp.zeros((count, len(footstep.ACTIONS))),
        )

    return build


def task_of(config: Config) -> Task:
    """What training's walkers decide and are told, the critic's share with it."""
    return replace(Task.of(config), privileged=config.ddpg.privileged)


def _initial_action(config: Config) -> tuple[float, ...]:
    with jax.ensure_compile_time_eval():
        person = Person.of(config.gait, jnp.float32(config.body.height), jnp.float32(config.body.mass))
        return tuple(float(x) for x in footstep.nominal_action(person))


def make(config: Config, mesh: Mesh, remembers: bool = True, learns: bool = True):
    """The compiled loop, TrainState -> TrainState, a report's windows further; it donates its input.

    Args:
      remembers, learns: parts that the benchmark leaves out: replay and statistics; the updates.
    """
    report = on_device(config, mesh.size, remembers, learns)
    mapped = jax.shard_map(report, mesh=mesh, in_specs=(_specs(),), out_specs=_specs(), check_vma=False)
    return jax.jit(mapped, donate_argnums=0)


def on_device(
    config: Config, devices: int, remembers: bool = True, learns: bool = True
) -> Callable[[TrainState], TrainState]:
    """What ``make`` runs on each of ``devices`` devices along `AXIS`, with that one's share of the state."""
    task, share = task_of(config), config.ddpg.batch_size // blocks(config)
    total = float(config.train.footsteps)

    def gather(state: TrainState, key: PRNGKeyArray) -> TrainState:
        mine = _mine(config.train.walkers, devices)
        scales = noise.scale(config.ddpg, state.footsteps / total, config.train.walkers)[mine]

        on_key, key = jax.random.split(key)
        on = partial(noise.on, config.ddpg, config.train.window_ticks * config.physics.timestep)
        exploration = jax.vmap(on)(state.exploration, _keys(on_key, mine))

        def act(observation: Float[Array, "B O"], _: Key[Array, " B"]) -> Float[Array, "B 2"]:
            actions = learner.act(config.ddpg, state.learner, observation)
            return jnp.clip(actions + scales[:, None] * exploration, -1.0, 1.0)

        shares = course.shares(state.course, config.pushes.focus)
        steppers, brought = collect.window(config, task, state.steppers, act, _keys(key, mine), shares)
        steps, closed, landed = brought.footsteps, brought.footsteps.closed, brought.landed
        sums = Counts(
            footsteps=jnp.sum(landed, dtype=jnp.float32),
            falls=jnp.sum(brought.fell, dtype=jnp.float32),
            truncations=jnp.sum(brought.truncated, dtype=jnp.float32),
            broken=jnp.sum(brought.broken, dtype=jnp.float32),
            reward=_sum(closed, steps.transition.reward),
            speed=_sum(landed, steps.speed),
            length=_sum(landed, steps.length),
            seconds=_sum(landed, steps.seconds),
        )
        told = course.counted(brought.dealt), course.counted(brought.lost)
        sums, told = jax.lax.psum((sums, told), AXIS)
        if remembers:
            state = state.replace(
                replay=replay_buffer.add(state.replay, steps.transition, closed),
                learner=learner.observe(state.learner, steps.transition.observation, closed, axis_name=AXIS),
            )
        return state.replace(
            steppers=steppers,
            exploration=exploration,
            counts=jax.tree.map(jnp.add, state.counts, sums),
            course=course.remembered(state.course, *told),
            footsteps=state.footsteps + sums.footsteps,
            owed=state.owed + sums.footsteps * config.ddpg.updates_per_footstep,
        )

    def learn(state: TrainState, key: PRNGKeyArray) -> TrainState:
        filled = jax.lax.pmin(jnp.min(state.replay.size), AXIS) > 0  # nothing is drawn from an empty ring
        ready = (state.footsteps >= config.ddpg.warmup) & filled
        due = jnp.where(ready, jnp.floor(state.owed), 0.0)
        count = blocks(config)
        mine = _mine(count, devices)

        def update(i: Array, current: LearnerState) -> LearnerState:
            sample_key, noise_key = jax.random.split(jax.random.fold_in(key, i))
            bits = jax.random.bits(sample_key, (count, share), jnp.uint32)
            drawn = replay_buffer.sample(state.replay, bits[mine], config.ddpg.return_steps)
            keys = _keys(noise_key, _mine(count * share, devices))
            return learner.update(config.ddpg, current, drawn, keys, axis_name=AXIS)[0]

        learned = jax.lax.fori_loop(0, due.astype(jnp.int32), update, state.learner)
        # What fell due before the first update is forgiven, or it would all come at once.
        return state.replace(learner=learned, owed=jnp.where(ready, state.owed - due, 0.0))

    def turn(state: TrainState, _: None) -> tuple[TrainState, None]:
        key, collect_key, learn_key = jax.random.split(state.key, 3)
        state = gather(state, collect_key)
        return (learn(state, learn_key) if learns else state).replace(key=key), None

    def report(state: TrainState) -> TrainState:
        fresh = state.replace(counts=_no_counts())
        return jax.lax.scan(turn, fresh, length=config.train.windows_per_report)[0]

    return report


def returns(config: Config, mesh: Mesh) -> Callable[[TrainState], Float[Array, "2"]]:
    """The compiled comparison of the critic with what came: discounted returns from the decisions of the last
    while on, the means of what it believes now of what was done, and of what was earned then, pushed and
    exploring as training is, the critic's word taken after `RETURN_STEPS` decisions; not a number before
    there are any."""

    def on_device(state: TrainState) -> Float[Array, "2"]:
        memory, known = state.replay, state.learner
        steps = max(1, min(RETURN_STEPS, memory.capacity // 2))
        walkers = memory.size.shape[0]
        spread = (memory.capacity - steps) * jnp.arange(1, RETURNS + 1) // RETURNS
        age = steps + jnp.minimum(spread, RETURN_SPACING * jnp.arange(1, RETURNS + 1))
        ring = jnp.repeat(jnp.arange(walkers), RETURNS)
        age = jnp.tile(age, walkers)
        then = replay_buffer.followed(memory, ring, (memory.position[ring] - age) % memory.capacity, steps)
        believed = learner.value(config.ddpg, known, then.observation, then.action)
        after = learner.act(config.ddpg, known, then.next_observation)
        came = then.reward + then.discount * learner.value(config.ddpg, known, then.next_observation, after)
        told = age <= memory.size[ring]
        sums = jnp.stack([_sum(told, believed), _sum(told, came), jnp.sum(told, dtype=jnp.float32)])
        sums = jax.lax.psum(sums, AXIS)
        return sums[:2] / sums[2]

    same = PartitionSpec()
    return jax.jit(jax.shard_map(on_device, mesh=mesh, in_specs=(_specs(),), out_specs=same, check_vma=False))


def _mine(count: int, devices: int) -> Int[Array, " N"]:
    """Which of ``count`` are this device's, as indices into all."""
    local = count // devices
    return jax.lax.axis_index(AXIS) * local + jnp.arange(local)


def _keys(key: PRNGKeyArray, index: Int[Array, " N"]) -> Key[Array, " N"]:
    """A key for each of those that ``index`` counts [N]."""
    return jax.vmap(jax.random.fold_in, in_axes=(None, 0))(key, index)


def _sum(mask: Array, values: Array) -> Array:
    return jnp.sum(jnp.where(mask, values, 0.0))
