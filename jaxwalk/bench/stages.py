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
from jaxtyping import Array, Float, PRNGKeyArray

from jaxwalk import controllers, footstep, physics, sensors, walker, windows
from jaxwalk.bench.programs import bare_steps
from jaxwalk.bench.rounds import BARE, LOOP, TICK
from jaxwalk.config import Config
from jaxwalk.devices import AXIS
from jaxwalk.physics import Plant
from jaxwalk.sensors import Estimate, SensorState
from jaxwalk.stepper import Stepper, Task
from jaxwalk.train import loop
from jaxwalk.walker import Walker

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
    PLANT: "physics.step: what one tick hands to the next, servos that saturate",
    SENSORS: "the instruments and their filters",
    GAIT: "the gait's clock, touch-downs, controllers",
    PUSHES: "pushes, and noise drawn ahead: the whole of walker.tick",
    TICK: "footsteps that close with observation and reward, at the nominal step: stepper.tick",
    WINDOWS: "block by block in windows; pushes drawn anew, the fallen replaced",
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
    setup = task.setup
    model, where = walker.model(setup, body.person), physics.layout(setup.body)

    def tick(plant: Plant, command: Float[Array, "6"]) -> tuple[Plant, None]:
        return walker.move(setup, model, body.person, plant, where.control(command), _nothing())[0], None

    return jax.lax.scan(tick, body.plant, commands)[0]


def sensed_steps(task: Task, body: Walker, commands: Float[Array, "T 6"]) -> Sensed:
    """And the instruments read, without noise."""
    setup = task.setup
    model, where = walker.model(setup, body.person), physics.layout(setup.body)

    def tick(state: Sensed, command: Float[Array, "6"]) -> tuple[Sensed, None]:
        plant, readings = walker.move(
            setup, model, body.person, state.plant, where.control(command), _nothing()
        )
        measured = sensors.measure(setup.sensors, setup.timestep, state.sensors, readings, jnp.zeros(18))
        return Sensed(plant, *measured), None

    return jax.lax.scan(tick, Sensed(body.plant, body.sensors, body.estimate), commands)[0]


def controlled_ticks(task: Task, ticks: int, body: Walker) -> Walker:
    """The closed loop: gait and controllers command; nothing pushes, without noise."""
    setup = task.setup
    model, where = walker.model(setup, body.person), physics.layout(setup.body)

    def tick(body: Walker, _: None) -> tuple[Walker, None]:
        bones = walker.skeleton(setup, body.person)
        command = controllers.command(body.person.gait, bones, body.gait, body.estimate)
        moved = walker.move(setup, model, body.person, body.plant, where.control(command), _nothing())
        return walker.moved(setup, body, *moved, jnp.zeros(18))[0], None

    return jax.lax.scan(tick, body, length=ticks)[0]


def body_ticks(task: Task, count: int, body: Walker) -> Walker:
    """``count`` windows of `walker.tick`, noise drawn ahead for each, as `windows.run_ticks` does."""
    setup = task.setup
    model = walker.model(setup, body.person)

    def tick(body: Walker, white: Float[Array, "18"]) -> tuple[Walker, None]:
        return walker.tick(setup, model, body, white)[0], None

    def window(body: Walker, _: None) -> tuple[Walker, None]:
        return jax.lax.scan(tick, body, walker.noise(body, setup.window_ticks))[0], None

    return jax.lax.scan(window, body, length=count)[0]


def nominal_windows(
    config: Config, task: Task, steppers: Stepper, key: PRNGKeyArray
) -> tuple[Stepper, PRNGKeyArray, Float[Array, ""]]:
    """A report's windows of all walkers at their nominal step; and the footsteps they closed."""

    def window(carry: tuple[Stepper, PRNGKeyArray], _: None) -> tuple[tuple[Stepper, PRNGKeyArray], Array]:
        states, key = carry
        key, here = jax.random.split(key)
        actions = jax.vmap(footstep.nominal_action)(states.walker.person)
        keys = jax.random.split(jax.random.fold_in(here, jax.lax.axis_index(AXIS)), states.asked.shape[0])
        states, brought = windows.window(config, task, states, lambda *_: actions, keys)
        return (states, key), jnp.sum(brought.footsteps.closed, dtype=jnp.float32)

    length = config.train.windows_per_report
    (steppers, key), closed = jax.lax.scan(window, (steppers, key), length=length)
    return steppers, key, jax.lax.psum(jnp.sum(closed), AXIS)


def windowed(config: Config, mesh: Mesh) -> Callable[..., Any]:
    """`nominal_windows`, compiled for walkers that are split over the mesh; gives up its walkers."""
    rows, same = PartitionSpec(AXIS), PartitionSpec()
    mapped = jax.shard_map(
        partial(nominal_windows, config, Task.of(config)),
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
    return loop.make(config, mesh, remembers=name != POLICY, learns=name == LOOP)


def _nothing() -> Float[Array, "7 2"]:
    """No loads."""
    return jnp.zeros((7, 2))
