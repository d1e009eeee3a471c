"""Walks written down tick by tick, many at once: what the sensors told, and what was decided."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from operator import itemgetter
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from flax import struct
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from jaxwalk.common.parallel import devices
from jaxwalk.config import Config
from jaxwalk.learn.policies.named import Subject
from jaxwalk.model import pushes
from jaxwalk.task import backend, rollout, scenarios, stepper
from jaxwalk.task.stepper import Stepper, Task
from jaxwalk.task.trials import SETTLE_SECONDS

PUSH_SECONDS = 4.0  # the first push begins then; the others within the step after it
SPREAD_SECONDS = 0.45  # over which pushes are spread, so that they meet all phases of the step


class Trace(struct.PyTreeNode):
    """[N walkers, T ticks] after each tick.

    Attributes:
      velocity: of the torso's centre, the truth, m/s.
      raw, mean, filtered: [.., 2] measured velocity (m/s) and acceleration (m/s^2): as it comes, after the
        moving mean, after the Kalman filter too.
      pitch: of the torso, the truth, rad.
      elapsed: since the last touch-down, s. toe_off: how long its toe-off lasts, s. torque: of it, N m.
      length, duration: commanded for the step under way (m, s).
      pushing: the push acts.
      fell: the walker lies.
    """

    velocity: Float[Array, "*B T"]
    raw: Float[Array, "*B T 2"]
    mean: Float[Array, "*B T 2"]
    filtered: Float[Array, "*B T 2"]
    pitch: Float[Array, "*B T"]
    elapsed: Float[Array, "*B T"]
    toe_off: Float[Array, "*B T"]
    torque: Float[Array, "*B T"]
    length: Float[Array, "*B T"]
    duration: Float[Array, "*B T"]
    pushing: Bool[Array, "*B T"]
    fell: Bool[Array, "*B T"]


def _look(_: Task, after: Stepper) -> Trace:
    body = after.walker
    seen, gait = body.sensors, body.gait
    return Trace(
        velocity=seen.last_velocity,
        raw=seen.history[-1],
        mean=jnp.mean(seen.history, axis=0),
        filtered=seen.filtered,
        pitch=body.plant.qpos[2],
        elapsed=gait.elapsed,
        toe_off=gait.toe_off_seconds,
        torque=gait.toe_off,
        length=gait.length,
        duration=gait.duration,
        pushing=pushes.active(body.push, body.tick - 1),
        fell=after.terminated,
    )


def _begin(task: Task, config: Config, key: PRNGKeyArray, start: Int[Array, ""], force: Float[Array, ""]):
    person = (
        jnp.float32(config.body.height),
        jnp.float32(config.body.mass),
        jnp.float32(config.sensors.noise),
    )
    state = stepper.start(task, config.gait, *person, key)
    ticks = pushes.whole_ticks(config.pushes.duration, task.setup.timestep)
    push = pushes.none().replace(start=start, ticks=jnp.int32(ticks), force=force)
    return state.replace(walker=state.walker.replace(push=push))


class Recorder:
    """One subject's compiled walk.

    Args:
      batch: walkers at once; rounded up to whole blocks of the devices.
    """

    def __init__(self, subject: Subject, batch: int) -> None:
        task = self._task = Task.of(subject.config).endless()
        mesh = devices.mesh()
        block = backend.block(task.setup)
        whole = mesh.size * block
        self.batch = -(-batch // whole) * whole
        self.timestep = task.setup.timestep
        self._config = subject.config
        windows = max(1, round(1.0 / (self.timestep * task.setup.window_ticks)))
        self._segment = windows * task.setup.window_ticks
        each = partial(rollout.segment, task, subject.act, windows, rollout.watched(_look))
        self._start = devices.spread(
            lambda k, s, f: devices.each(partial(_begin, task, subject.config), k, s, f, block=block),
            mesh,
            (True,) * 3,
        )
        self._advance = devices.spread(
            lambda params, states: devices.each(partial(each, params), states, block=block),
            mesh,
            (False, True),
        )

    def record(
        self,
        params: Any,
        seed: int,
        walkers: int,
        seconds: float,
        impulse: float,
        progress: Callable[[float], None],
    ) -> Trace:
        """[walkers, T] on the host; with a push all of it, else from `SETTLE_SECONDS` on."""
        dt, config = self.timestep, self._config
        keys = scenarios.keys(seed, scenarios.PUSHED if impulse else scenarios.CALM, self.batch)
        spread = np.arange(self.batch) / self.batch * SPREAD_SECONDS
        starts = np.round((PUSH_SECONDS + spread) / dt) if impulse else np.full(self.batch, pushes.NEVER)
        ticks = pushes.whole_ticks(config.pushes.duration, dt)
        force = np.full(self.batch, impulse / (ticks * dt), np.float32)
        states = self._start(keys, jnp.asarray(starts, jnp.int32), jnp.asarray(force))
        segments, kept = int(np.ceil(seconds)), []
        late = 0 if impulse else round(SETTLE_SECONDS / dt)
        for walked in range(segments):
            states, rows = self._advance(params, states)
            rows = jax.device_get(jax.tree.map(itemgetter(slice(walkers)), rows))
            skip = max(0, late - walked * self._segment)
            kept.append(jax.tree.map(lambda x, skip=skip: x[:, skip:], rows))
            progress((walked + 1) / segments)
        return jax.tree.map(lambda *x: np.concatenate(x, axis=1), *kept)


def landings(trace: Trace, walker: int) -> np.ndarray:
    """Ticks at which the walker's feet touch down, while it is up."""
    clock = trace.elapsed[walker]
    landed = np.flatnonzero(clock[1:] < clock[:-1]) + 1
    return landed[~trace.fell[walker][landed]]
