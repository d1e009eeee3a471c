"""Rigid legs through a step: see `jaxwalk.deploy.forms`."""

from __future__ import annotations

import dataclasses

import numpy as np

from jaxwalk.deploy.kinematics import Posture
from jaxwalk.deploy.person import Person
from jaxwalk.deploy.rigid import back_step, controllers, phases
from jaxwalk.deploy.sensors import Estimate, Sensors
from jaxwalk.deploy.step_clock import Clock

command = controllers.command


def let_go(said: Sensors) -> np.ndarray:
    """[6] hips at rest, knees as ``said``, ankles without torque."""
    free = np.zeros((2, 3), np.float32)
    free[:, 1] = said.joints[:, 1]
    return free.reshape(6)


def start(who: Person, gravity: np.float32, posture: Posture, estimate: Estimate, stance: int) -> Clock:
    """The clock at the touch-down of ``stance``, its step the nominal one."""
    torque, seconds = controllers.toe_off(who, posture, estimate, 1 - stance)
    length, duration = np.float32(who.gait.length_nominal), np.float32(who.gait.duration_nominal)
    zero = np.float32(0)
    return Clock(stance, zero, length, duration, torque, seconds, zero, zero, zero)


def proceed(
    who: Person,
    gravity: np.float32,
    posture: Posture,
    clock: Clock,
    estimate: Estimate,
    timestep: np.float32,
) -> tuple[Clock, bool]:
    """The clock after a tick, and whether a foot landed in it."""
    landed = phases.touched_down(who.gait, posture, clock, estimate)
    landed = landed or back_step.touched_down(who, gravity, posture, clock, estimate)
    # At a touch-down the legs swap: the one that was in stance trails and pushes off.
    trailing = clock.stance if landed else clock.swing
    torque, seconds = controllers.toe_off(who, posture, estimate, trailing)
    if not landed:
        return phases.pressed(who.gait, clock, torque, seconds), False
    return dataclasses.replace(
        clock, stance=clock.swing, elapsed=np.float32(0), toe_off=torque, toe_off_seconds=seconds
    ), True
