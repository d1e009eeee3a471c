"""Rigid legs through a step: see `jaxwalk.control.forms`."""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from jaxwalk.control.person import Person, inertias
from jaxwalk.control.rigid import back_step, controllers, phases
from jaxwalk.control.sensors import Estimate
from jaxwalk.control.step_clock import StepClock
from jaxwalk.model.engine import Setup
from jaxwalk.model.kinematics import Skeleton, thigh_angles


def start(
    setup: Setup, person: Person, bones: Skeleton, estimate: Estimate, stance: Int[Array, ""]
) -> StepClock:
    """The clock at the touch-down of ``stance``, its step the nominal one."""
    torque, seconds = _toe_off(setup, person, bones, estimate, 1 - stance)
    numbers = person.gait
    return StepClock(
        stance=stance,
        elapsed=jnp.zeros(()),
        length=numbers.length_nominal * jnp.ones(()),
        duration=numbers.duration_nominal * jnp.ones(()),
        toe_off=torque,
        toe_off_seconds=seconds,
    )


def command(
    setup: Setup, person: Person, bones: Skeleton, clock: StepClock, estimate: Estimate
) -> Float[Array, "6"]:
    """Hip rate (rad/s), knee angle (rad), ankle torque (N m) for the servos; left, right."""
    return controllers.command(person.gait, bones, clock, estimate)


def proceed(
    setup: Setup, person: Person, bones: Skeleton, clock: StepClock, estimate: Estimate
) -> tuple[StepClock, Bool[Array, ""]]:
    """The clock after a tick, and whether a foot landed in it: toe-off then begins, or presses on."""
    where = (person.gait, bones, clock, estimate)
    landed = phases.touched_down(*where) | back_step.touched_down(*where)
    # At a touch-down the legs swap: the one that was in stance trails and pushes off.
    trailing = jnp.where(landed, clock.stance, 1 - clock.stance)
    torque, seconds = _toe_off(setup, person, bones, estimate, trailing)
    clock = phases.pressed(person.gait, clock, torque, seconds)
    restarted = clock.replace(
        stance=1 - clock.stance, elapsed=jnp.zeros(()), toe_off=torque, toe_off_seconds=seconds
    )
    return jax.tree.map(lambda new, old: jnp.where(landed, new, old), restarted, clock), landed


def _toe_off(
    setup: Setup, person: Person, bones: Skeleton, estimate: Estimate, trailing: Int[Array, ""]
) -> tuple[Float[Array, ""], Float[Array, ""]]:
    angles = thigh_angles(estimate.joints, estimate.pitch)
    angle = angles[trailing]
    knee = estimate.joints[trailing, 1]
    numbers = person.gait
    # The leg turns about its ankle; policies of before took it to reach to the sole.
    leg = bones.thigh + bones.shank if numbers.toe_off_form == "paper" else bones.leg
    torque = controllers.toe_off_torque(
        numbers, inertias(setup, person), leg, estimate.speed, angle, angles[1 - trailing], knee
    )
    if numbers.back_step:  # after one, the leg that would push is ahead, and would push further back
        torque = jnp.where(angle < 0, torque, 0.0)
    return controllers.push_off(numbers, setup.physics.ankle_limit * person.ratio.torque, torque)
