"""Compliant legs through a step: see `jaxwalk.control.forms`."""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from jaxwalk.control import posture
from jaxwalk.control.compliant import stance as standing
from jaxwalk.control.compliant import step_plan, swing
from jaxwalk.control.person import Person
from jaxwalk.control.sensors import Estimate
from jaxwalk.control.step_clock import Path, StepClock
from jaxwalk.model import strength
from jaxwalk.model.engine import Setup
from jaxwalk.model.kinematics import Skeleton


def start(
    setup: Setup, person: Person, bones: Skeleton, estimate: Estimate, stance: Int[Array, ""]
) -> StepClock:
    """The clock at the touch-down of ``stance``, its step the nominal one."""
    numbers = person.gait
    return StepClock(
        stance=stance,
        elapsed=jnp.zeros(()),
        length=numbers.length_nominal * jnp.ones(()),
        duration=numbers.duration_nominal * jnp.ones(()),
        toe_off=standing.push_off(numbers, estimate, jnp.zeros(())),
        toe_off_seconds=numbers.compliant.toe_off_seconds * jnp.ones(()),
        path=_path(estimate, 1 - stance),
        change=jnp.zeros(2) if numbers.steps == "planned" else None,
        lag=jnp.zeros(()),
    )


def command(
    setup: Setup, person: Person, bones: Skeleton, clock: StepClock, estimate: Estimate
) -> Float[Array, "6"]:
    """Torques of hip, knee and ankle, N m, that the joints can give; left, right."""
    numbers, where = person.gait, posture.of(bones, estimate)
    error = standing.capture_error(numbers, bones, clock, where)
    stands = jnp.stack(
        [
            standing.hip(numbers, bones, clock, where, estimate, error),
            standing.knee(numbers, clock, estimate),
            standing.ankle(numbers, clock, where, estimate, error),
        ]
    )
    swings = swing.torques(numbers, clock, where, estimate)
    asked = jnp.where(clock.is_stance[:, None], stands, swings).reshape(6)
    return strength.limited(setup.physics.actuators, person.ratio, asked, estimate.joint_rates.reshape(6))


def proceed(
    setup: Setup, person: Person, bones: Skeleton, clock: StepClock, estimate: Estimate
) -> tuple[StepClock, Bool[Array, ""]]:
    """The clock after a tick, and whether a foot landed in it: the path of the other leg then begins.

    What a policy changes of the planned step holds until it is asked again.
    """
    numbers, where = person.gait, posture.of(bones, estimate)
    landed = swing.touched_down(numbers, clock, where, estimate)
    restarted = clock.replace(
        stance=1 - clock.stance, elapsed=jnp.zeros(()), path=_path(estimate, clock.stance)
    )
    clock = jax.tree.map(lambda new, old: jnp.where(landed, new, old), restarted, clock)
    if clock.change is not None:
        error = standing.capture_error(numbers, bones, clock, where)
        plan = step_plan.planned(numbers, clock, where, estimate, error)
        length, duration = step_plan.changed(numbers, plan, clock.change)
        clock = clock.replace(length=length, duration=duration)
    path = swing.proceed(numbers, bones, clock, where, estimate, setup.timestep)
    lag = standing.lagging(numbers, clock, estimate, setup.timestep)
    return clock.replace(path=path, lag=lag, toe_off=standing.push_off(numbers, estimate, lag)), landed


def _path(estimate: Estimate, leg: Int[Array, ""]) -> Path:
    """The path of a ``leg`` that begins to swing: from where it is."""
    return Path(angle=estimate.joints[leg, 0], rate=estimate.joint_rates[leg, 0])
