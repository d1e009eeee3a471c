"""What a planar walker is made of, and the ways between its joints and its bodies, in NumPy.

Conventions are the MJCF's: x forward, z up, pitch positive leaning forward. Joints are the root's x and z
(m) and pitch (rad), then one hinge a body. Bodies come after their parents, the root first.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np


class Motion(NamedTuple):
    """Of [B] bodies: ``place`` [B, 2] of the centres (m), ``pitch`` [B] (rad), and their rates."""

    place: np.ndarray
    pitch: np.ndarray
    speed: np.ndarray
    spin: np.ndarray


@dataclass(frozen=True)
class Tree:
    """B bodies, K balls under their feet, A actuators; D = B + 2 joints.

    Attributes:
      timestep: of a tick, s. gravity: m/s^2.
      parent: [B] the body that each hangs on, -1 for the root.
      anchor: [B, 2] its joint from the parent's, x and z in the parent's frame, m.
      centre: [B, 2] its centre of mass from its own joint, in its own frame, m.
      mass: [B] kg. inertia: [B] about the centre, pitch axis, kg m^2.
      turn: [B] 1 where its joint's positive sense leans it forward, -1 where backward.
      damping: [B] passive, of its joint, N m s/rad.
      imu: [2] of the root's frame, m.
      foot: [K] the body that each ball belongs to. ball: [K, 2] its centre from that body's joint, m.
      radius: [K] m. stiffness: [K] N/m. yielding: [K] the contact's damping, N s/m.
      friction: sliding, of all balls.
      soles: [2] bodies whose floor contact the touch sensors feel, left and right.
      driven: [A] the body whose joint each actuator turns.
      gain, offset, rate: [A] torque = gain x command + offset x angle + rate x its rate (N m),
      limit: [A] within +- this, N m.
    """

    timestep: float
    gravity: float
    parent: np.ndarray
    anchor: np.ndarray
    centre: np.ndarray
    mass: np.ndarray
    inertia: np.ndarray
    turn: np.ndarray
    damping: np.ndarray
    imu: np.ndarray
    foot: np.ndarray
    ball: np.ndarray
    radius: np.ndarray
    stiffness: np.ndarray
    yielding: np.ndarray
    friction: float
    soles: np.ndarray
    driven: np.ndarray
    gain: np.ndarray
    offset: np.ndarray
    rate: np.ndarray
    limit: np.ndarray

    @cached_property
    def _chains(self) -> tuple[np.ndarray, np.ndarray]:
        """Pitches from joints, [B, B]; and [2, B, B]: centre i is the root's place and, of each body b, a
        vector fixed in it, [:, i, b]."""
        count = len(self.parent)
        pitches, ways = np.zeros((count, count)), np.zeros((count, count, 2))
        for body, above in enumerate(self.parent):
            if above >= 0:
                pitches[body] = pitches[above]
                ways[body] = ways[above]
                ways[body, above] = self.anchor[body]
            pitches[body, body] = self.turn[body]
            ways[body, body] = self.centre[body]
        return pitches, np.moveaxis(ways, 2, 0).copy()

    def _turned(self, pitch: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """[B, B] x and z of `_chains`' vectors as the bodies lie; turning one moves its end by (z, -x)."""
        x, z = self._chains[1]
        c, s = np.cos(pitch), np.sin(pitch)
        return x * c + z * s, z * c - x * s

    def motion(self, qpos: np.ndarray, qvel: np.ndarray) -> Motion:
        """Where the bodies are and how they move, of joints [D] and their rates."""
        pitches = self._chains[0]
        pitch, spin = pitches @ qpos[2:], pitches @ qvel[2:]
        x, z = self._turned(pitch)
        place = qpos[:2] + np.stack([x.sum(1), z.sum(1)], axis=1)
        return Motion(place, pitch, qvel[:2] + np.stack([z @ spin, -x @ spin], axis=1), spin)

    def joints(self, moved: Motion) -> tuple[np.ndarray, np.ndarray]:
        """[D] joints and their rates, of bodies whose joints may have come a little apart.

        The pitches are kept. What is off is taken back so that neither the centre of all masses nor linear
        and angular momentum change: the rates are those next to the bodies' own, weighed by mass, which is
        the very projection that ODE's next step would begin with; and what the shifted masses lack in angular
        momentum, the whole is turned by.
        """
        x, z = self._turned(moved.pitch)
        closed = np.stack([x.sum(1), z.sum(1)], axis=1)
        share = self.mass / self.mass.sum()
        centre = share @ moved.place
        root = centre - share @ closed
        # Unknown: the root's velocity and all spins; a body's speed is root + (z, -x) @ spin.
        count = len(share)
        ways = np.zeros((2 * count, 2 + count))
        ways[:count, 0] = ways[count:, 1] = 1.0
        ways[:count, 2:], ways[count:, 2:] = z, -x
        weighed = ways.T * np.concatenate([self.mass, self.mass])
        square, told = weighed @ ways, weighed @ moved.speed.T.ravel()
        spins = np.arange(2, 2 + count)
        square[spins, spins] += self.inertia
        told[2:] += self.inertia * moved.spin
        rates = np.linalg.solve(square, told)

        shift, arm = moved.place - closed - root, closed + root - centre
        lacking = self.mass @ (shift[:, 1] * moved.speed[:, 0] - shift[:, 0] * moved.speed[:, 1])
        turn = lacking / (self.mass @ (arm**2).sum(1) + self.inertia.sum())
        whole = root - centre
        rates += turn * np.concatenate([[whole[1], -whole[0]], np.ones(count)])
        back = self._from_pitches
        return np.concatenate([root, back @ moved.pitch]), np.concatenate([rates[:2], back @ rates[2:]])

    @cached_property
    def _from_pitches(self) -> np.ndarray:
        return np.linalg.inv(self._chains[0])

    def balls(self, moved: Motion) -> tuple[np.ndarray, np.ndarray]:
        """[K, 2] centres of the balls, and [K] how deep they are in the floor, m; negative above it."""
        c, s = np.cos(moved.pitch[self.foot]), np.sin(moved.pitch[self.foot])
        x, z = (self.ball - self.centre[self.foot]).T
        centres = moved.place[self.foot] + np.stack([x * c + z * s, z * c - x * s], axis=1)
        return centres, self.radius - centres[:, 1]
