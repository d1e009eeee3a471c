"""Walkers in the laboratory: unpushed, tick by tick, from the steady gait on."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from operator import itemgetter

import jax
import numpy as np
from flax import struct
from jaxtyping import Array, Bool, Float
from mujoco import mjx

from jaxwalk.common.parallel import devices
from jaxwalk.control import walker
from jaxwalk.control.person import skeleton
from jaxwalk.learn.policies.named import Subject
from jaxwalk.measure.gait import forces
from jaxwalk.measure.gait.forces import Forces
from jaxwalk.model import kinematics, physics
from jaxwalk.task import rollout, stepper
from jaxwalk.task.scenarios import Scenario
from jaxwalk.task.stepper import Stepper, Task
from jaxwalk.task.trials import SETTLE_SECONDS

BATCH = 64  # walkers in one program, at most


class Ticks(struct.PyTreeNode):
    """What is written down of each tick: at its start, but for what `Forces` says.

    Attributes:
      pitch: of the torso, forward positive, rad.
      joints: [2, 3] hip and knee flexion, ankle dorsiflexion of each leg, rad.
      ankle_x: [2] where the ankles are, forward, m.
      forces: of the tick.
      fell: the walker lies.
    """

    pitch: Float[Array, "*T"]
    joints: Float[Array, "*T 2 3"]
    ankle_x: Float[Array, "*T 2"]
    forces: Forces
    fell: Bool[Array, "*T"]


def tick(task: Task, model: mjx.Model, state: Stepper) -> tuple[Stepper, Ticks]:
    """The tick that `stepper.tick` makes, and what is written down of it; the plant moves once."""
    setup, body = task.setup, state.walker
    body, control, push = walker.drive(setup, body)
    made_with, data = physics.advance(setup.body, setup.physics, model, body.plant, control, push)
    white = walker.noise(body, 1)[0]
    plant, readings = physics.outcome(setup.body, data)
    after = stepper.advance(task, state, *walker.advance(setup, body, plant, readings, white))

    bones = skeleton(setup, body.person)
    where = physics.layout(setup.body)
    joints, pitch = where.sagittal(body.plant.qpos), body.plant.qpos[2]
    x, _ = kinematics.ankles(bones, joints, pitch)
    return after, Ticks(
        pitch=pitch,
        joints=joints,
        ankle_x=body.plant.qpos[0] + x,
        forces=forces.of_tick(where, bones, body.plant, made_with, data),
        fell=after.terminated,
    )


def record(
    subject: Subject, scenarios: Scenario, seconds: float, tell: Callable[[float], None] = lambda share: None
) -> Iterator[Ticks]:
    """Walk for ``seconds``, rounded up to whole ones; what comes before `SETTLE_SECONDS` is left out.

    Args:
      scenarios: [N]; their pushes are not made.
      tell: called with the share that is done.

    Yields:
      [B, T] batches of walkers on the host, N in all, in order.
    """
    task = Task.of(subject.config).endless()
    setup, count = task.setup, scenarios.impulse.shape[0]
    mesh = devices.mesh()
    batch = -(-min(BATCH, count) // mesh.size) * mesh.size
    windows = max(1, round(1.0 / (setup.timestep * setup.window_ticks)))
    each = partial(rollout.segment, task, subject.act, windows, tick)
    begin = devices.spread(lambda one: jax.vmap(partial(_begin, task, subject))(one), mesh, (True,))
    advance = devices.spread(
        lambda params, states: devices.each(partial(each, params), states), mesh, (False, True)
    )
    segment = windows * setup.window_ticks
    segments, settle = int(np.ceil(seconds - 1e-9)), round(SETTLE_SECONDS / setup.timestep)
    parts = -(-count // batch)
    for part in range(parts):
        # The last batch is filled up with walkers that nobody reads.
        index = np.arange(part * batch, (part + 1) * batch)
        real = index < count
        states, kept = begin(jax.tree.map(itemgetter(index % count), scenarios)), []
        for walked in range(segments):
            states, rows = advance(subject.params, states)
            if (walked + 1) * segment > settle:
                late = max(0, settle - walked * segment)
                part_rows = jax.device_get(rows)
                kept.append(jax.tree.map(itemgetter((real, slice(late, None))), part_rows))
            jax.block_until_ready(rows)
            tell((part * segments + walked + 1) / (parts * segments))
        yield jax.tree.map(lambda *x: np.concatenate(x, axis=1), *kept)


def _begin(task: Task, subject: Subject, scenario: Scenario) -> Stepper:
    return stepper.start(
        task, subject.config.gait, scenario.height, scenario.mass, scenario.noise, scenario.key
    )
