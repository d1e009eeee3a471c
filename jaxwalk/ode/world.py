"""A tree in ODE, a tick at a time.

ODE's axes are x forward, y up, z to the right, since its planar joint keeps a body in the plane of x and y:
the root is held there by it, all others by their hinges. Between ticks a walker is its joints and their
rates, from which every tick places the bodies anew. ODE's own state is theirs and no more, but that its
joints come apart a little, which its next step would mend by their ERP; here they are closed at once
(`Tree.joints`).

Contacts are ODE's own soft ones. A spring (N/m) and a damper (N s/m), both taken at the step's end as ODE
takes all, are ERP = h k / (h k + d) and CFM = 1 / (h k + d). So are motors: a torque that is linear in the
joint's angle and rate within a limit is a motor whose FMax is the limit, with a CFM; ODE's velocity motor is
the one of infinite gain. Torques that are told are efforts on the hinges.
"""

from __future__ import annotations

import ctypes
import weakref
from ctypes import byref
from typing import Any, Literal

import numpy as np

from jaxwalk.ode import library
from jaxwalk.ode.tree import Motion, Tree

Method = Literal["world", "quick"]
"""ODE's ``dWorldStep`` (a direct method), or its ``dWorldQuickStep`` (an iteration, as Gazebo takes)."""

ITERATIONS = 50  # of the quick step: Gazebo's default
MOST = 1e4  # m, rad and their rates: ODE's own checks would end the process over much more


class World:
    """One tree of bodies in a world of its own.

    Args:
      tree: what there is.
      method: how ODE solves a step.
      steps: of ODE, a tick.

    Raises:
      UserError: no ODE here.
    """

    def __init__(self, tree: Tree, method: Method = "world", steps: int = 1) -> None:
        self.tree = tree
        self._ode = ode = library.load()
        self._steps, self._h = steps, tree.timestep / steps
        self._step = {"world": ode.dWorldStep, "quick": ode.dWorldQuickStep}[method]
        self._world = ode.dWorldCreate()
        weakref.finalize(self, ode.dWorldDestroy, self._world)
        ode.dWorldSetGravity(self._world, 0.0, -tree.gravity, 0.0)
        ode.dWorldSetQuickStepNumIterations(self._world, ITERATIONS)
        self._bodies = [self._body(m, i) for m, i in zip(tree.mass, tree.inertia, strict=True)]
        nought = np.zeros(len(tree.parent) + 2)
        begun = tree.motion(nought, nought)
        self._place(begun)
        ode.dJointAttach(ode.dJointCreatePlane2D(self._world, None), self._bodies[0], None)
        corners = begun.place - tree.centre  # no body is turned yet
        self._hinges = [self._hinge(body, *corners[body]) for body in range(1, len(self._bodies))]
        # Contact joints and what is told of their forces live within `tick` alone.
        self._touching = ode.dJointGroupCreate(0)
        self._contacts = [self._contact(k) for k in range(len(tree.foot))]
        self._forces = [library.Feedback() for _ in tree.foot]
        self._seen = [
            tuple(library.seen(get(body), count) for get, count in self._getters()) for body in self._bodies
        ]
        torque = (tree.offset == 0) & (tree.rate == 0)
        self._efforts = [(a, self._hinges[tree.driven[a] - 1]) for a in np.flatnonzero(torque)]
        self._servos = [(a, self._hinges[tree.driven[a] - 1]) for a in np.flatnonzero(~torque)]
        for body in np.flatnonzero(tree.damping[1:]) + 1:
            self._motor(self._hinges[body - 1], 0.0, tree.damping[body], np.inf)

    def _getters(self) -> list[tuple[Any, int]]:
        ode = self._ode
        pairs = (ode.dBodyGetPosition, 3), (ode.dBodyGetQuaternion, 4)
        return [*pairs, (ode.dBodyGetLinearVel, 3), (ode.dBodyGetAngularVel, 3)]

    def _body(self, mass: float, inertia: float) -> Any:
        body, told = self._ode.dBodyCreate(self._world), library.Mass()
        # About the other axes, about which nothing turns, anything will do.
        self._ode.dMassSetParameters(byref(told), mass, 0, 0, 0, inertia, inertia, inertia, 0, 0, 0)
        self._ode.dBodySetMass(body, byref(told))
        self._ode.dBodySetFiniteRotationMode(body, 1)  # or a turn by more than a little falls short
        return body

    def _hinge(self, body: int, x: float, y: float) -> Any:
        """The hinge of ``body`` on its parent, at (x, y)."""
        ode, tree = self._ode, self.tree
        hinge = ode.dJointCreateHinge(self._world, None)
        ode.dJointAttach(hinge, self._bodies[body], self._bodies[tree.parent[body]])
        ode.dJointSetHingeAnchor(hinge, x, y, 0.0)
        ode.dJointSetHingeAxis(hinge, 0.0, 0.0, -float(tree.turn[body]))  # ODE's z is to the right
        return hinge

    def _motor(self, hinge: Any, target: float, gain: float, limit: float) -> None:
        """Torque = ``gain`` (N m s/rad) x (``target`` - rate), within +-``limit`` N m."""
        for parameter, value in ((library.VEL, target), (library.FMAX, limit), (library.CFM, 1 / gain)):
            self._ode.dJointSetHingeParam(hinge, parameter, value)

    def _contact(self, ball: int) -> library.Contact:
        tree = self.tree
        contact = library.Contact(mode=library.SURFACE, mu=tree.friction, mu2=0.0)
        hard = self._h * tree.stiffness[ball] + tree.yielding[ball]
        contact.soft_erp, contact.soft_cfm = self._h * tree.stiffness[ball] / hard, 1 / hard
        contact.normal[1] = contact.fdir1[0] = 1.0
        return contact

    def _place(self, moved: Motion) -> None:
        ode, turned = self._ode, (ctypes.c_double * 4)()
        rows = np.concatenate(
            [moved.place, moved.speed, moved.spin[:, None], moved.pitch[:, None] / -2], axis=1
        )
        sines, cosines = np.sin(rows[:, 5]).tolist(), np.cos(rows[:, 5]).tolist()
        for body, (x, y, vx, vy, spin, _), s, c in zip(
            self._bodies, rows.tolist(), sines, cosines, strict=True
        ):
            ode.dBodySetPosition(body, x, y, 0.0)
            turned[0], turned[3] = c, s
            ode.dBodySetQuaternion(body, turned)
            ode.dBodySetLinearVel(body, vx, vy, 0.0)
            ode.dBodySetAngularVel(body, 0.0, 0.0, -spin)

    def _moved(self, before: Motion) -> Motion:
        """How the bodies lie and move; pitches are counted on from ``before``."""
        place, turned, speed, spin = (np.array(rows) for rows in zip(*self._seen, strict=True))
        pitch = -2 * np.arctan2(turned[:, 3], turned[:, 0])
        pitch += 2 * np.pi * np.round((before.pitch - pitch) / (2 * np.pi))
        return Motion(place[:, :2], pitch, speed[:, :2], -spin[:, 2])

    def tick(
        self, qpos: np.ndarray, qvel: np.ndarray, control: np.ndarray, push: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """One tick.

        Args:
          qpos, qvel: [D] joints and their rates, m and rad.
          control: [A] command of each actuator.
          push: [B, 2] forward force (N) and pitching moment (N m) at each body's centre of mass.

        Returns:
          Joints and rates [D] after it, and [11] what MuJoCo's sensors tell of its start: the IMU's velocity
          (m/s), the torso's long axis, its angular velocity (rad/s), the force under each sole (N). NaN
          throughout from a walker that is not finite, or faster or farther than `MOST`.
        """
        nothing = np.full_like(qpos, np.nan), np.full_like(qvel, np.nan), np.full(11, np.nan)
        # Hip x alone may grow for ever; places come back relative to it.
        if not (np.abs(qpos[1:]) < MOST).all() or not (np.abs(qvel) < MOST).all() or not np.isfinite(qpos[0]):
            return nothing
        if not (np.isfinite(control).all() and np.isfinite(push).all()):
            return nothing
        tree, at = self.tree, qpos - np.eye(1, len(qpos))[0] * qpos[0]
        begun = moved = tree.motion(at, qvel)
        self._place(begun)
        touch = np.zeros(2)
        for _ in range(self._steps):
            touch += self._advance(moved, control, push) / self._steps
            moved = self._moved(moved)
        after, rates = tree.joints(moved)
        after[0] += qpos[0]
        return after, rates, np.concatenate([self.imu(begun, qvel), touch])

    def imu(self, begun: Motion, qvel: np.ndarray) -> np.ndarray:
        """[9] velocity, long axis and angular velocity of the root."""
        c, s, spin = np.cos(begun.pitch[0]), np.sin(begun.pitch[0]), begun.spin[0]
        x, z = self.tree.imu
        velocity = qvel[0] + spin * (z * c - x * s), 0.0, qvel[1] - spin * (x * c + z * s)
        return np.array([*velocity, s, 0.0, c, 0.0, spin, 0.0])

    def _advance(self, moved: Motion, control: np.ndarray, push: np.ndarray) -> np.ndarray:
        """[2] N under each sole in a step of ODE, which this makes."""
        ode, tree = self._ode, self.tree
        self._drive(moved, control)
        for body, (force, moment) in zip(self._bodies, push.tolist(), strict=True):
            if force or moment:
                ode.dBodyAddForce(body, force, 0.0, 0.0)
                ode.dBodyAddTorque(body, 0.0, 0.0, -moment)
        centres, depths = tree.balls(moved)
        pressed = np.flatnonzero(depths > 0).tolist()
        for k in pressed:
            contact = self._contacts[k]
            contact.pos[0], contact.pos[1] = centres[k, 0], centres[k, 1] - tree.radius[k]
            contact.depth = depths[k]
            joint = ode.dJointCreateContact(self._world, self._touching, byref(contact))
            ode.dJointAttach(joint, self._bodies[tree.foot[k]], None)
            ode.dJointSetFeedback(joint, byref(self._forces[k]))
        ode.dRandSetSeed(0)  # the quick step shuffles its rows by it
        self._step(self._world, self._h)
        ode.dJointGroupEmpty(self._touching)
        touch = np.zeros(2)
        for k in pressed:
            touch[tree.foot[k] == tree.soles] += self._forces[k].f1[1]
        return touch

    def _drive(self, moved: Motion, control: np.ndarray) -> None:
        tree, ode = self.tree, self._ode
        torques = np.minimum(np.maximum(tree.gain * control, -tree.limit), tree.limit).tolist()
        for a, hinge in self._efforts:
            ode.dJointAddHingeTorque(hinge, torques[a])
        for a, hinge in self._servos:
            body = tree.driven[a]
            angle = tree.turn[body] * (moved.pitch[body] - moved.pitch[tree.parent[body]])
            gain = -(tree.rate[a] + self._h * tree.offset[a])
            self._motor(
                hinge, (tree.gain[a] * control[a] + tree.offset[a] * angle) / gain, gain, tree.limit[a]
            )
