"""Walks of one walker on real physics, written down tick by tick."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from flax import struct
from jaxtyping import Array, Bool, Float, Int

from jaxwalk.config import Engine
from jaxwalk.control import walker
from jaxwalk.learn.policies.named import Subject
from jaxwalk.model import pushes
from jaxwalk.model.burdens import Burden
from jaxwalk.task import rollout, scenarios, stepper
from jaxwalk.task.stepper import Stepper, Task

SEGMENT = 50  # decision windows in one call of the compiled program, whatever the seconds asked for
FALL_SECONDS = 1.2  # written down after a fall
CAMERA_SECONDS = 1.2  # over which the camera's way is smoothed: the hip's pace within a step is not followed


@dataclass(frozen=True)
class Shove:
    """A push.

    Attributes:
      impulse: N s, forward positive.
      time: when it begins, s.
      duration: s.
      height: of the point pushed, above the torso's centre, m.
      place: the segment pushed, an index into `push_points.PLACES`.
    """

    impulse: float
    time: float
    duration: float = 0.1
    height: float = 0.0
    place: int = pushes.TORSO


@dataclass(frozen=True)
class Footfall:
    """A touch-down.

    Attributes:
      time: s.
      leg: that landed, 0 left, 1 right.
      length: of the step that it ends, by the encoders, m; negative for a step back.
      seconds: how long that step lasted, from the start or the touch-down before.
    """

    time: float
    leg: int
    length: float
    seconds: float


@dataclass(frozen=True)
class Walk:
    """What was walked.

    Attributes:
      qpos: [N, D] after each tick, the start first.
      timestep: s.
      pushes: in order, with the whole ticks that they lasted.
      fell: when, s; None if it never did.
      speed: [n] of the torso's centre after each tick until the walk's end or the fall, m/s.
      footfalls: in order.
    """

    qpos: np.ndarray
    timestep: float
    pushes: tuple[Shove, ...]
    fell: float | None
    speed: np.ndarray
    footfalls: tuple[Footfall, ...]

    @property
    def seconds(self) -> float:
        """How long was walked, s."""
        return (len(self.qpos) - 1) * self.timestep

    def pushed(self, second: float) -> Shove | None:
        """The push that began last, up to ``second``."""
        return next((one for one in reversed(self.pushes) if one.time <= second), None)


class Ticks(struct.PyTreeNode):
    """What is written down of each tick, after it.

    Attributes:
      qpos, qvel: pose and its rates.
      speed: of the torso's centre, forward, m/s.
      landed: a foot touched down. leg: the one in stance, 0 left, 1 right.
      length: how far the foot that landed last is ahead of the other, m; read where ``landed``.
      fell: the walker lies; it is not moved any more.
    """

    qpos: Float[Array, "*T D"]
    qvel: Float[Array, "*T D"]
    speed: Float[Array, "*T"]
    landed: Bool[Array, "*T"]
    leg: Int[Array, "*T"]
    length: Float[Array, "*T"]
    fell: Bool[Array, "*T"]


def _look(task: Task, after: Stepper) -> Ticks:
    body = after.walker
    return Ticks(
        qpos=body.plant.qpos,
        qvel=body.plant.qvel,
        speed=body.sensors.last_velocity,
        landed=(body.gait.elapsed == 0) & ~after.terminated,
        leg=body.gait.stance,
        length=walker.landed_length(task.setup, body),
        fell=after.terminated,
    )


class Loop:
    """The closed loop of one subject, compiled once for all of its walks.

    Args:
      windows: decision windows in one `advance`.
      engine: what moves the walker.
    """

    def __init__(self, subject: Subject, windows: int, engine: Engine = "mjx") -> None:
        config = subject.config
        self._params = subject.params
        self._task = Task.of(config, engine).endless()
        self._start = jax.jit(partial(stepper.start, self._task, config.gait))
        self._person = tuple(map(jnp.float32, (config.body.height, config.body.mass, config.sensors.noise)))
        tick = rollout.watched(_look)
        self._segment = jax.jit(partial(rollout.segment, self._task, subject.act, windows, tick))
        self.timestep = self._task.setup.timestep
        self.ticks = windows * self._task.setup.window_ticks

    def start(self, seed: int, burden: Burden | None = None) -> Stepper:
        """A walker that has just landed; ``seed`` is of its start and its noise."""
        return self._start(*self._person, scenarios.root(seed, scenarios.RECORDED), burden)

    def pushed(self, state: Stepper, shove: Shove) -> Stepper:
        """``state``, to be pushed when its life comes to ``shove.time``."""
        dt = self.timestep
        begin, height = jnp.int32(round(shove.time / dt)), jnp.float32(shove.height)
        push = pushes.of_impulse(jnp.float32(shove.impulse), begin, shove.duration, dt, height)
        push = push.replace(place=jnp.int32(shove.place))
        return state.replace(walker=state.walker.replace(push=push))

    def whole(self, shove: Shove) -> Shove:
        """``shove`` as it comes: at a tick, for whole ticks."""
        dt = self.timestep
        lasts = pushes.whole_ticks(shove.duration, dt) * dt
        return dataclasses.replace(shove, time=round(shove.time / dt) * dt, duration=lasts)

    def advance(self, state: Stepper) -> tuple[Stepper, Ticks]:
        """The walker ``ticks`` ticks further, and these on the host, [ticks] each."""
        state, rows = self._segment(self._params, state)
        return state, jax.device_get(rows)


def record(loop: Loop, model: mujoco.MjModel, seconds: float, seed: int, shove: Shove | None = None) -> Walk:
    """Walk for ``seconds``, or until `FALL_SECONDS` after a fall.

    Args:
      model: the limp body (`scene.model`), which falls on where the walker has lost.
    """
    state, met = loop.start(seed), ()
    if shove is not None:
        state, met = loop.pushed(state, shove), (loop.whole(shove),)
    return dataclasses.replace(walked(loop, model, round(seconds / loop.timestep), state), pushes=met)


def walked(
    loop: Loop,
    model: mujoco.MjModel,
    ticks: int,
    state: Stepper,
    meet: Callable[[int, Stepper], Stepper] = lambda tick, state: state,
) -> Walk:
    """What becomes of ``state`` in ``ticks`` ticks, or until `FALL_SECONDS` after a fall; its pushes are left
    to whoever gave them.

    Args:
      meet: what happens before each call of ``loop``, at its tick.
    """
    dt = loop.timestep
    qpos = [np.asarray(state.walker.plant.qpos)[None]]
    speed = [np.asarray(state.walker.sensors.last_velocity)[None]]
    footfalls: list[Footfall] = []
    fell = None
    for begun in range(0, ticks, loop.ticks):
        state, rows = loop.advance(meet(begun, state))
        rows = jax.tree.map(lambda x, n=ticks - begun: x[:n], rows)
        last = int(rows.fell.argmax()) if rows.fell.any() else len(rows.fell) - 1
        for i in np.flatnonzero(rows.landed[: last + 1]):
            now, before = (begun + int(i) + 1) * dt, footfalls[-1].time if footfalls else 0.0
            footfalls.append(Footfall(now, int(rows.leg[i]), float(rows.length[i]), now - before))
        qpos.append(rows.qpos[: last + 1])
        speed.append(rows.speed[: last + 1])
        if rows.fell[last]:
            fell = (begun + last + 1) * dt
            limp = min(round(FALL_SECONDS / dt), ticks - begun - last - 1)
            qpos.append(collapse(model, rows.qpos[last], rows.qvel[last], limp))
            break
    return Walk(np.concatenate(qpos), dt, (), fell, np.concatenate(speed), tuple(footfalls))


def collapse(model: mujoco.MjModel, qpos: np.ndarray, qvel: np.ndarray, ticks: int) -> np.ndarray:
    """[ticks, D] what becomes of a body that nothing holds up any more."""
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = qpos, qvel
    rows = np.empty((ticks, len(qpos)))
    for row in rows:
        mujoco.mj_step(model, data)
        row[:] = data.qpos
    return rows


def camera_path(walk: Walk) -> np.ndarray:
    """[N] x of the picture's middle, m: the hip's, smoothed to both sides so that it does not lag."""
    half = min(round(CAMERA_SECONDS / walk.timestep / 2), len(walk.qpos) - 1)
    if half == 0:
        return walk.qpos[:, 0]
    padded = np.pad(walk.qpos[:, 0], half, mode="reflect", reflect_type="odd")
    window = np.hanning(2 * half + 3)[1:-1]
    return np.convolve(padded, window / window.sum(), mode="valid")
