"""A walker that is watched: it goes on window by window, is pushed, falls and starts anew."""

from __future__ import annotations

import mujoco
import numpy as np

from jaxwalk.show.recording import Loop, Shove
from jaxwalk.show.scene import Arrow
from jaxwalk.show.viewer import keys
from jaxwalk.show.viewer.keys import Wishes


class Session:
    """The walker, whose pose is always that of ``data``.

    Args:
      loop: the closed loop. seed: of the first start; each start after it has the next.
      model: the limp body (`scene.model`), which falls on where the walker has lost.

    Attributes:
      seconds: since the start. speed: of the torso, m/s.
      fell: when, s; None while it is up.
      push: the last one of this walk; None before.
      starts: how often it has started.
    """

    def __init__(self, loop: Loop, model: mujoco.MjModel, seed: int) -> None:
        self._loop, self._model, self._seed = loop, model, seed
        self.data = mujoco.MjData(model)
        self.starts = 0
        self._start()

    def _start(self) -> None:
        self._state = self._loop.start((self._seed + self.starts) % 2**32)
        self.starts += 1
        self._ticks = 0
        self.fell: float | None = None
        self.push: Shove | None = None
        plant = self._state.walker.plant
        self._pose(np.asarray(plant.qpos), np.asarray(plant.qvel))
        self.speed = float(self._state.walker.sensors.last_velocity)

    @property
    def seconds(self) -> float:
        """Walked since the start, s."""
        return self._ticks * self._loop.timestep

    @property
    def window(self) -> float:
        """How long one `advance` lasts, s."""
        return self._loop.ticks * self._loop.timestep

    def advance(self, wishes: Wishes) -> Wishes:
        """Go on for one window as ``wishes`` say, and give what of them is left; paused, nothing happens."""
        if wishes.paused:
            return wishes
        if wishes.restart:
            self._start()
        elif wishes.push and self.fell is None:
            self.push = Shove(wishes.push, self.seconds)
            self._state = self._loop.pushed(self._state, self.push)
        if self.fell is None:
            self._walk()
        else:
            for _ in range(self._loop.ticks):
                mujoco.mj_step(self._model, self.data)
            self._ticks += self._loop.ticks
        return keys.granted(wishes)

    def _walk(self) -> None:
        self._state, rows = self._loop.advance(self._state)
        if rows.fell.any():
            self.fell = (self._ticks + int(rows.fell.argmax()) + 1) * self._loop.timestep
        self._ticks += self._loop.ticks
        self.speed = float(rows.speed[-1])
        self._pose(np.asarray(rows.qpos[-1]), np.asarray(rows.qvel[-1]))

    def _pose(self, qpos: np.ndarray, qvel: np.ndarray) -> None:
        self.data.qpos[:], self.data.qvel[:] = qpos, qvel
        self.data.time = self.seconds
        mujoco.mj_forward(self._model, self.data)

    @property
    def arrow(self) -> Arrow | None:
        """The push as it is drawn now; None: there is none, or it has faded."""
        return Arrow.at(self.push, self.seconds)
