"""What a tick of training is made of, one stage added to the next, each by the package's own functions.

The stages up to `FOOTSTEPS` are programs of one walker and replay the same ticks at every call. Those after
it are programs of all walkers, which go on walking; the last is the training loop.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax.sharding import Mesh, PartitionSpec
from jaxtyping import Array, Float, Int, PRNGKeyArray

from jaxwalk.common.parallel.devices import AXIS
from jaxwalk.config import Config
from jaxwalk.control import sensors, walker
from jaxwalk.control.person import Person, model_of
from jaxwalk.control.sensors import Estimate, SensorState
from jaxwalk.control.walker import Walker
from jaxwalk.learn.train import device_loop
from jaxwalk.measure.bench.programs import bare_steps
from jaxwalk.measure.bench.rounds import BARE, BY_XLA, LOOP, TICK
from jaxwalk.model import engine, physics
from jaxwalk.model.physics import Plant, Readings
from jaxwalk.task import backend, collect, footstep
from jaxwalk.task.stepper import Stepper, Task

PLANT, SENSORS, GAIT, PUSHES, WINDOWS, POLICY, REPLAY = (
    "plant",
    "sensors",
    "gait_and_controllers",
    "pushes_and_noise",
    "windows",
    "policy",
    "replay",
)
STAGES = {
    BARE: "mjx.step on the whole of its data",
    BY_XLA: "beside it: the whole tick (stepper.tick) as XLA compiles it",
    PLANT: "physics.step: what one tick hands to the next, servos that saturate",
    SENSORS: "the instruments and their filters",
    GAIT: "the step's clock, touch-downs, controllers",
    PUSHES: "pushes and noise: the whole of walker.tick",
    TICK: "footsteps that close with observation and reward, at the nominal step: stepper.tick",
    WINDOWS: "in windows; pushes drawn anew, the fallen replaced",
    POLICY: "the actor asked and perturbed, footsteps counted",
    REPLAY: "replay written, observations' statistics kept",
    LOOP: "updates: the training loop",
}
"""In order, and what each adds to the one before."""

OF_WALKER = (BARE, PLANT, SENSORS, GAIT, PUSHES)  # these replay commands, or are one walker's alone


class Sensed(NamedTuple):
    """What a tick of plant and instruments hands on."""

    plant: Plant
    sensors: SensorState
    estimate: Estimate


def plant_steps(task: Task, body: Walker, commands: Float[Array, "T 6"]) -> Plant:
    """The ticks of `programs.bare_steps`, by the package's own step."""
    return _replayed(task, _plant_tick, body.plant, body.person, commands)


def sensed_steps(task: Task, body: Walker, commands: Float[Array, "T 6"]) -> Sensed:
    """The ticks of `plant_steps`, and the instruments read, without noise."""
    return _replayed(
        task, _sensed_tick, Sensed(body.plant, body.sensors, body.estimate), body.person, commands
    )


def controlled_ticks(task: Task, ticks: int, body: Walker) -> Walker:
    """The closed loop: gait and controllers command; nothing pushes, without noise."""
    return _windows(task, _controlled_tick, ticks // task.setup.window_ticks, body)


def body_ticks(task: Task, count: int, body: Walker) -> Walker:
    """``count`` windows of `walker.tick`, noise and all."""
    return _windows(task, _body_tick, count, body)


def _plant_tick(task: Task, person: Person, plant: Plant, command: Float[Array, "6"]) -> Plant:
    return _moved(task, person, plant, command)[0]


def _sensed_tick(task: Task, person: Person, state: Sensed, command: Float[Array, "6"]) -> Sensed:
    plant, readings = _moved(task, person, state.plant, command)
    setup = task.setup
    measured = sensors.measure(setup.sensors, setup.timestep, state.sensors, readings, jnp.zeros(18))
    return Sensed(plant, *measured)


def _moved(task: Task, person: Person, plant: Plant, command: Float[Array, "6"]) -> tuple[Plant, Readings]:
    setup = task.setup
    control = physics.layout(setup.body).control(command)
    return engine.move(
        setup, model_of(setup, person), person.ratio, person.burden, plant, control, jnp.zeros((7, 2))
    )


def _controlled_tick(task: Task, body: Walker) -> tuple[Walker, None]:
    setup = task.setup
    command = walker.command(setup, body)
    moved = _moved(task, body.person, body.plant, command)
    return walker.advance(setup, body, *moved, jnp.zeros(18))[0], None


def _body_tick(task: Task, body: Walker) -> tuple[Walker, None]:
    return walker.tick(task.setup, model_of(task.setup, body.person), body)[0], None


def _windows(task: Task, tick: Callable[..., Any], count: int, body: Walker) -> Walker:
    """``count`` windows of ``tick``."""
    ticks = task.setup.window_ticks

    def window(body: Walker, _: None) -> tuple[Walker, None]:
        def by_xla() -> tuple[Walker, None]:
            return jax.lax.scan(lambda body, _: tick(task, body), body, length=ticks)

        return backend.scan(task.setup, tick, task, ticks, body, otherwise=by_xla)

    return jax.lax.scan(window, body, length=count)[0]


def _replayed(
    task: Task, tick: Callable[..., Any], state: Any, person: Person, commands: Float[Array, "T 6"]
) -> Any:
    """Ticks of one walker that follows ``commands``, window by window.

    Args:
      tick: of (task, who, state, command) to the new state.
    """
    ticks = task.setup.window_ticks

    def window(state: Any, commands: Float[Array, "W 6"]) -> tuple[Any, None]:
        def by_xla() -> tuple[Any, None]:
            walked, _ = jax.lax.scan(lambda one, it: (tick(task, person, one, it), None), state, commands)
            return (walked, jnp.int32(ticks)), None

        told = backend.scan(
            task.setup,
            _follow,
            (tick, task),
            ticks,
            (state, jnp.int32(0)),
            person,
            commands,
            otherwise=by_xla,
        )
        return told[0][0], None

    return jax.lax.scan(window, state, commands.reshape(-1, ticks, 6))[0]


def _follow(
    setting: tuple[Callable[..., Any], Task],
    state: tuple[Any, Int[Array, ""]],
    person: Person,
    commands: Float[Array, "W 6"],
) -> tuple[Any, None]:
    """One tick, by the next of the window's commands."""
    (tick, task), (now, at) = setting, state
    return (tick(task, person, now, jax.lax.dynamic_index_in_dim(commands, at, keepdims=False)), at + 1), None


def nominal_windows(
    config: Config, task: Task, steppers: Stepper, key: PRNGKeyArray
) -> tuple[Stepper, PRNGKeyArray, Float[Array, ""]]:
    """A report's windows of all walkers at their nominal step; and the footsteps they made."""

    def window(carry: tuple[Stepper, PRNGKeyArray], _: None) -> tuple[tuple[Stepper, PRNGKeyArray], Array]:
        states, key = carry
        key, here = jax.random.split(key)
        actions = jax.vmap(footstep.nominal_action)(states.walker.person)
        keys = jax.random.split(jax.random.fold_in(here, jax.lax.axis_index(AXIS)), states.asked.shape[0])
        states, brought = collect.window(config, task, states, lambda *_: actions, keys)
        return (states, key), jnp.sum(brought.landed, dtype=jnp.float32)

    length = config.train.windows_per_report
    (steppers, key), landed = jax.lax.scan(window, (steppers, key), length=length)
    return steppers, key, jax.lax.psum(jnp.sum(landed), AXIS)


def windowed(config: Config, mesh: Mesh) -> Callable[..., Any]:
    """`nominal_windows`, compiled for walkers that are split over the mesh; gives up its walkers."""
    rows, same = PartitionSpec(AXIS), PartitionSpec()
    mapped = jax.shard_map(
        partial(nominal_windows, config, device_loop.task_of(config)),
        mesh=mesh,
        in_specs=(rows, same),
        out_specs=(rows, same, same),
        check_vma=False,
    )
    return jax.jit(mapped, donate_argnums=0)


def of_walker(name: str, config: Config, task: Task, count: int) -> tuple[Callable[..., Any], bool]:
    """The program of one walker of the stage ``name``, and whether it replays commands."""
    ticks = count * task.setup.window_ticks
    return {
        BARE: (partial(bare_steps, config, task), True),
        PLANT: (partial(plant_steps, task), True),
        SENSORS: (partial(sensed_steps, task), True),
        GAIT: (partial(controlled_ticks, task, ticks), False),
        PUSHES: (partial(body_ticks, task, count), False),
    }[name]


def of_training(name: str, config: Config, mesh: Mesh) -> Callable[..., Any]:
    """The training loop up to the stage ``name``."""
    return device_loop.make(config, mesh, remembers=name != POLICY, learns=name == LOOP)
