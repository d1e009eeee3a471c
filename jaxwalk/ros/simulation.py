"""The walker in ODE as the simulation node has it: commands in, instruments out; efforts, wrenches."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from jaxwalk.ode import Method, World
from jaxwalk.ros import wire
from jaxwalk.ros.body import Body
from jaxwalk.ros.wire import Frame


@dataclass(frozen=True)
class Load:
    """What a service asked for: ``row`` of efforts or of bodies, from ``begin`` on for ``lasts`` ns.

    Attributes:
      values: torque (N m) of a joint; forward force (N) and pitching moment (N m) at a body's centre.
    """

    row: int
    values: tuple[float, ...]
    begin: int
    lasts: int

    def acts(self, now: int) -> bool:
        """Whether it does so in the tick that begins at ``now``, ns."""
        return self.begin <= now and (self.lasts < 0 or now < self.begin + self.lasts)


def unfit(frame: str, point: tuple[float, ...], force: tuple[float, ...], torque: tuple[float, ...]) -> str:
    """What is wrong with a wrench, [3] each as a service is asked for it, or ""."""
    if frame not in ("", "world"):
        return f"reference_frame {frame}: give world"
    if any((*point, *force[1:], torque[0], torque[2])):
        return "give a force along x and a torque about y at reference_point 0 0 0, the body's centre"
    return ""


class Simulation:
    """One walker.

    Args:
      method: of ODE's steps.

    Attributes:
      qpos, qvel: [9] joints and rates. frame: what the instruments said last. ticks: made since the start.
    """

    def __init__(self, body: Body, method: Method = "world") -> None:
        self.body = body
        self._world = World(body.tree, method)
        self._nanoseconds = round(body.tree.timestep * 1e9)
        self.reset()

    def reset(self) -> None:
        """Back to the start; loads are forgotten."""
        self.qpos, self.qvel, self.ticks = self.body.qpos, self.body.qvel, 0
        self._efforts: list[Load] = []
        self._wrenches: list[Load] = []
        at = self._world.tree.motion(self.qpos, self.qvel)
        sensed = np.concatenate([self._world.imu(at, self.qvel), self.body.touch])
        self._velocity = float(sensed[0])
        self.frame = self._frame(sensed)

    @property
    def now(self) -> int:
        """Simulated time, ns."""
        return self.ticks * self._nanoseconds

    def effort(self, joint: str, torque: float, begin: int, lasts: int) -> str:
        """Add ``torque`` (N m) to a joint's own from ``begin`` on; gives what is wrong with that, or ""."""
        if joint not in self.body.joints:
            return f"no joint {joint}: give one of {', '.join(self.body.joints)}"
        if wrong := _unfit((torque,), lasts):
            return wrong
        self._efforts.append(Load(self.body.joints.index(joint), (torque,), max(begin, self.now), lasts))
        return ""

    def wrench(self, body: str, force: float, moment: float, begin: int, lasts: int) -> str:
        """Push the centre of a body; as `effort`."""
        if body not in self.body.segments:
            return f"no body {body}: give one of {', '.join(self.body.segments)}"
        if wrong := _unfit((force, moment), lasts):
            return wrong
        row = self.body.segments.index(body)
        self._wrenches.append(Load(row, (force, moment), max(begin, self.now), lasts))
        return ""

    def tick(self, command: tuple[float, ...]) -> Frame:
        """One tick under ``command``, [6] N m; joints whose command is not a number are passive."""
        torque = np.array(command, float)
        torque[~np.isfinite(torque)] = 0.0
        push = np.zeros((len(self.body.segments), 2))
        for load in self._acting(self._efforts):
            torque[load.row] += load.values[0]
        for load in self._acting(self._wrenches):
            push[load.row] += load.values
        self.qpos, self.qvel, sensed = self._world.tick(self.qpos, self.qvel, torque, push)
        self.ticks += 1
        self.frame = self._frame(sensed)
        return self.frame

    def _acting(self, loads: list[Load]) -> list[Load]:
        loads[:] = [load for load in loads if load.lasts < 0 or self.now < load.begin + load.lasts]
        return [load for load in loads if load.acts(self.now)]

    def _frame(self, sensed: np.ndarray) -> Frame:
        velocity, pitch = float(sensed[0]), float(np.arctan2(sensed[3], sensed[5]))
        before, self._velocity = self._velocity, velocity
        joints = self.body.tree.driven + 2
        return Frame(
            self.now,
            wire.turned(pitch),
            float(sensed[7]),
            (velocity - before) / self.body.tree.timestep,
            velocity,
            tuple(self.qpos[joints].tolist()),
            tuple(self.qvel[joints].tolist()),
            (float(sensed[9]), float(sensed[10])),
        )


def _unfit(values: tuple[float, ...], lasts: int) -> str:
    if not all(map(math.isfinite, values)):
        return "give finite numbers of N and N m"
    return "" if lasts else "duration 0: give how long, or a negative one for ever"
