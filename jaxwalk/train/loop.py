"""The training loop that stays on the device: collect a window, remember it, learn from memory.

Walkers and replay are split over the devices of a mesh, the learner is replicated and its
gradients are averaged; on a CPU the devices are its cores.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial

import jax
import jax.numpy as jnp
from flax import struct
from jax.sharding import Mesh, NamedSharding, PartitionSpec
from jaxtyping import Array, Float, PRNGKeyArray

from jaxwalk import footstep, walker, windows
from jaxwalk.config import Config
from jaxwalk.ddpg import learner, noise, replay
from jaxwalk.ddpg.learner import LearnerState
from jaxwalk.ddpg.replay import Replay
from jaxwalk.devices import AXIS
from jaxwalk.stepper import Stepper, Task


@struct.dataclass
class Counts:
    """Sums since the last report, equal on all devices.

    Attributes:
      footsteps: closed. falls, truncations: episodes that ended so. broken: those of the falls
        that a number that is not finite ended.
      reward, speed, length, seconds: sums over footsteps (m/s, m, s).
    """

    footsteps: Float[Array, ""]
    falls: Float[Array, ""]
    truncations: Float[Array, ""]
    broken: Float[Array, ""]
    reward: Float[Array, ""]
    speed: Float[Array, ""]
    length: Float[Array, ""]
    seconds: Float[Array, ""]


@struct.dataclass
class TrainState:
    """Everything that training changes. W walkers and their replay are sharded, the rest is replicated.

    Attributes:
      steppers: [W] walkers in mid-step.
      replay: [D] rings, one for each device.
      learner: networks, optimisers, statistics.
      counts: since the last report.
      footsteps: gathered in all.
      owed: updates due, fractions included.
      key: of exploration, renewals and sampling.
    """

    steppers: Stepper
    replay: Replay
    learner: LearnerState
    counts: Counts
    footsteps: Float[Array, ""]
    owed: Float[Array, ""]
    key: PRNGKeyArray


def _no_counts() -> Counts:
    return Counts(*[jnp.zeros(())] * 8)


def _specs() -> TrainState:
    split, same = PartitionSpec(AXIS), PartitionSpec()
    return TrainState(split, split, same, same, same, same, same)


def init(config: Config, mesh: Mesh, seed: int) -> TrainState:
    """A run at its start, laid out over the mesh."""
    return _initial(config, mesh)(jax.random.key(seed))


@cache
def _initial(config: Config, mesh: Mesh) -> Callable[[PRNGKeyArray], TrainState]:
    return jax.jit(_build(config, mesh), out_shardings=shardings(mesh))


def layout(config: Config, mesh: Mesh) -> TrainState:
    """What ``init`` gives, types and shapes only."""
    return jax.eval_shape(_build(config, mesh), jax.random.key(0))


def shardings(mesh: Mesh) -> TrainState:
    """How the parts of a ``TrainState`` lie on the mesh."""
    return jax.tree.map(
        lambda spec: NamedSharding(mesh, spec), _specs(), is_leaf=lambda x: isinstance(x, PartitionSpec)
    )


def _build(config: Config, mesh: Mesh) -> Callable[[PRNGKeyArray], TrainState]:
    task, devices = Task.of(config), mesh.size

    def build(key: PRNGKeyArray) -> TrainState:
        walkers_key, learner_key, key = jax.random.split(key, 3)
        keys = jax.random.split(walkers_key, config.train.walkers)
        steppers = jax.vmap(partial(windows.spawn, config, task))(keys)
        capacity = max(config.ddpg.replay_capacity // devices, config.ddpg.batch_size // devices)
        example = jax.tree.map(lambda x: x[0], steppers.last.transition)
        ring = replay.init(capacity, example)
        return TrainState(
            steppers=steppers,
            replay=jax.tree.map(lambda x: jnp.broadcast_to(x, (devices, *x.shape)), ring),
            learner=learner.init(config.ddpg, learner_key, len(config.observation), _initial_action(config)),
            counts=_no_counts(),
            footsteps=jnp.zeros(()),
            owed=jnp.zeros(()),
            key=key,
        )

    return build


def _initial_action(config: Config) -> tuple[float, ...]:
    with jax.ensure_compile_time_eval():
        who = walker.person(config.gait, jnp.float32(config.body.height), jnp.float32(config.body.mass))
        return tuple(float(x) for x in footstep.nominal_action(who))


def make(config: Config, mesh: Mesh):
    """The compiled loop, TrainState -> TrainState, a report's windows further; it donates its input."""
    report = on_device(config, mesh.size)
    mapped = jax.shard_map(report, mesh=mesh, in_specs=(_specs(),), out_specs=_specs(), check_vma=False)
    return jax.jit(mapped, donate_argnums=0)


def on_device(config: Config, devices: int) -> Callable[[TrainState], TrainState]:
    """What ``make`` runs on each of ``devices`` devices along `AXIS`, with that one's share of the state."""
    task = Task.of(config)
    batch = max(1, config.ddpg.batch_size // devices)
    total = float(config.train.footsteps)

    def collect(state: TrainState, key: PRNGKeyArray) -> TrainState:
        local = state.steppers.asked.shape[0]
        scales = noise.scale(config.ddpg, state.footsteps / total, local * devices)
        mine = jax.lax.dynamic_slice_in_dim(scales, jax.lax.axis_index(AXIS) * local, local)

        def act(observation: Float[Array, "B O"], key: PRNGKeyArray) -> Float[Array, "B 2"]:
            return noise.perturb(learner.act(config.ddpg, state.learner, observation), key, mine)

        steppers, brought = windows.window(config, task, state.steppers, act, key)
        steps, closed = brought.footsteps, brought.footsteps.closed
        sums = Counts(
            footsteps=jnp.sum(closed, dtype=jnp.float32),
            falls=jnp.sum(brought.fell, dtype=jnp.float32),
            truncations=jnp.sum(brought.truncated, dtype=jnp.float32),
            broken=jnp.sum(brought.broken, dtype=jnp.float32),
            reward=_sum(closed, steps.transition.reward),
            speed=_sum(closed, steps.speed),
            length=_sum(closed, steps.length),
            seconds=_sum(closed, steps.seconds),
        )
        sums = jax.lax.psum(sums, AXIS)
        return state.replace(
            steppers=steppers,
            replay=replay.add(state.replay, steps.transition, closed),
            learner=learner.observe(state.learner, steps.transition.observation, closed, axis_name=AXIS),
            counts=jax.tree.map(jnp.add, state.counts, sums),
            footsteps=state.footsteps + sums.footsteps,
            owed=state.owed + sums.footsteps * config.ddpg.updates_per_footstep,
        )

    def learn(state: TrainState, key: PRNGKeyArray) -> TrainState:
        # No device may draw from an empty ring.
        ready = (state.footsteps >= config.ddpg.warmup) & (jax.lax.pmin(state.replay.size, AXIS) > 0)
        due = jnp.where(ready, jnp.floor(state.owed), 0.0)

        def update(i: Array, current: LearnerState) -> LearnerState:
            sample_key, update_key = jax.random.split(jax.random.fold_in(key, i))
            drawn = replay.sample(state.replay, sample_key, batch)
            return learner.update(config.ddpg, current, drawn, update_key, axis_name=AXIS)[0]

        learned = jax.lax.fori_loop(0, due.astype(jnp.int32), update, state.learner)
        # What fell due before the first update is forgiven, or it would all come at once.
        return state.replace(learner=learned, owed=jnp.where(ready, state.owed - due, 0.0))

    def turn(state: TrainState, _: None) -> tuple[TrainState, None]:
        key, collect_key, learn_key = jax.random.split(state.key, 3)
        here = jax.lax.axis_index(AXIS)
        state = collect(state, jax.random.fold_in(collect_key, here))
        state = learn(state, jax.random.fold_in(learn_key, here))
        return state.replace(key=key), None

    def report(state: TrainState) -> TrainState:
        mine = state.replace(replay=jax.tree.map(lambda x: x[0], state.replay), counts=_no_counts())
        mine, _ = jax.lax.scan(turn, mine, length=config.train.windows_per_report)
        return mine.replace(replay=jax.tree.map(lambda x: x[None], mine.replay))

    return report


def _sum(mask: Array, values: Array) -> Array:
    return jnp.sum(jnp.where(mask, values, 0.0))
