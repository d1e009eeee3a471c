"""One walker, one tick: sensors, controllers, physics and the step's clock closed into a loop."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
from flax import struct
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from jaxwalk.control import drives, forms, latency, sensors, step_clock
from jaxwalk.control.person import Person, reference_body, skeleton
from jaxwalk.control.step_clock import StepClock
from jaxwalk.model import anthropometry, burdens, engine, physics, pushes, strength
from jaxwalk.model.engine import Setup


class Walker(struct.PyTreeNode):
    """What one walker does now.

    Attributes:
      person: constant for its life.
      plant: rigid-body state.
      sensors: instruments' memory.
      estimate: what the sensors told after the last tick.
      gait: where in its step it is.
      push: the push it meets.
      key: of its noise.
      tick: ticks lived.
      walls: [2] normal force of the left and the right wall in the last tick, N; None in the plane.
      drives: what Gazebo's drives remember; None with servos.
      effort: positive power of all joints, averaged over about the time of a nominal step, W; None of joints
        that are not moved by torques.
      late: what instruments told and is not known yet; None for who bears nothing.
    """

    person: Person
    plant: physics.Plant
    sensors: sensors.SensorState
    estimate: sensors.Estimate
    gait: StepClock
    push: pushes.Push
    key: PRNGKeyArray
    tick: Int[Array, ""]
    walls: Float[Array, "2"] | None = None
    drives: drives.Drives | None = None
    effort: Float[Array, ""] | None = None
    late: latency.Late | None = None


class Event(struct.PyTreeNode):
    """What a tick brought.

    Attributes:
      touchdown: the swing foot landed, ahead or in a step back; ``walker.gait`` is that of the new step.
      fell: hip too low, torso too far over, or the step stalled.
      broken: a number of the state before it, or of the plant after it, is not finite (counts as a fall).
      step_length: of the step that ended, from the sensors, m.
      step_seconds: how long it lasted, s.
    """

    touchdown: Bool[Array, ""]
    fell: Bool[Array, ""]
    broken: Bool[Array, ""]
    step_length: Float[Array, ""]
    step_seconds: Float[Array, ""]


def start(
    setup: Setup, person: Person, key: PRNGKeyArray, noise: Float[Array, ""], spread: float = 1.0
) -> Walker:
    """A walker whose front foot has just landed.

    Thighs at about +-asin(0.26), soles level, about 1.1 m/s on the reference body, the
    torso not turning; ``spread`` scales the random differences between starts.
    """
    bones, where = skeleton(setup, person), physics.layout(setup.body)
    key, pose_key, side_key, sensor_key = jax.random.split(key, 4)
    jitter = spread * jax.random.uniform(pose_key, (3,), minval=-1.0, maxval=1.0)
    half = jnp.arcsin(0.26 * (1 + 0.1 * jitter[0]))
    speed = 1.1 * (1 + 0.1 * jitter[1]) * person.ratio.speed
    pitch = 0.05 + 0.05 * jitter[2]
    stance = jax.random.bernoulli(side_key).astype(jnp.int32)

    thigh = jnp.where(jnp.arange(2) == stance, half, -half)
    joints = jnp.stack([thigh + pitch, jnp.zeros(2), -thigh], axis=1)  # soles level
    straight = bones.thigh + bones.shank
    height = straight * jnp.cos(half) + bones.foot
    # Both legs turn about their ankles with the hip, the soles stay flat.
    turning = -speed / (straight * jnp.cos(half)) * jnp.ones(2)
    rates = jnp.stack([turning, jnp.zeros(2), -turning], axis=1)
    plant = physics.Plant(
        qpos=where.vector(jnp.stack([jnp.zeros(()), height, pitch]), joints),
        qvel=where.vector(jnp.stack([speed, jnp.zeros(()), jnp.zeros(())]), rates),
        warmstart=jnp.zeros(where.dofs),
    )
    state = sensors.start(setup.sensors, sensor_key, noise, speed)
    zero = jnp.zeros(())
    estimate = sensors.Estimate(
        speed=speed,
        acceleration=zero,
        pitch=pitch if person.burden is None else pitch - person.burden.slope,
        pitch_rate=zero,
        joints=joints,
        joint_rates=rates,
        touch=jnp.zeros(2),
    )
    clock = forms.of(person.gait).start(setup, person, bones, estimate, stance)
    walls = jnp.zeros(2) if where.walls else None
    motors = drives.start(where) if setup.physics.drives == "gazebo" else None
    late = None if person.burden is None else latency.start(setup.timestep, estimate)
    effort = zero if setup.physics.drives == "torque" else None
    return Walker(
        person, plant, state, estimate, clock, pushes.none(), key, jnp.int32(0), walls, motors, effort, late
    )


def _total(tree: Any) -> Float[Array, ""]:
    """The sum of all numbers in ``tree``: not finite if one is not, for none is near the largest float."""
    parts = [x for x in jax.tree.leaves(tree) if jnp.issubdtype(x.dtype, jnp.floating)]
    return jnp.sum(jnp.concatenate([jnp.ravel(x) for x in parts]))


def landed_length(setup: Setup, walker: Walker) -> Float[Array, ""]:
    """How far the foot that landed last is ahead of the other, from the encoders, m."""
    return -step_clock.step_length(skeleton(setup, walker.person), walker.gait, walker.estimate)


def decide(walker: Walker, action: Float[Array, "2"]) -> Walker:
    """Give the step under way its (length m, duration s); or, where it is planned, what is changed of it."""
    if walker.gait.change is not None:
        return walker.replace(gait=walker.gait.replace(change=action))
    return walker.replace(gait=walker.gait.replace(length=action[0], duration=action[1]))


def has_fallen(setup: Setup, walker: Walker) -> Bool[Array, ""]:
    """Hip below ``fall_height`` of standing, torso beyond ``fall_pitch``, or a stalled step."""
    numbers = walker.person.gait
    _, height, pitch = walker.plant.qpos[:3]
    low = height < numbers.fall_height * skeleton(setup, walker.person).leg
    return low | (jnp.abs(pitch) > numbers.fall_pitch) | (walker.gait.elapsed > numbers.stall_seconds)


def command(setup: Setup, walker: Walker) -> Float[Array, "6"]:
    """What the controllers tell the joints: see `forms.of`."""
    bones = skeleton(setup, walker.person)
    return forms.of(walker.person.gait).command(setup, walker.person, bones, walker.gait, walker.estimate)


def drive(setup: Setup, walker: Walker) -> tuple[Walker, Float[Array, "A"], Float[Array, "7 2"]]:
    """The walker with its drives and the push it meets told, and what acts on its plant in the coming tick:
    control and loads."""
    person, where = walker.person, physics.layout(setup.body)
    told = command(setup, walker)
    walker = walker.replace(push=pushes.met(walker.push, walker.tick, walker.gait.stance))
    loads = pushes.loads(walker.push, walker.tick, walker.plant.qpos[2])
    rates = where.sagittal(walker.plant.qvel).reshape(6)
    if person.burden is not None:
        masses = anthropometry.masses(reference_body(setup)) * person.ratio.mass
        loads = loads.at[0].set(burdens.felt(person.burden, masses[0], loads[0], walker.plant.qpos[2]))
        loads = loads.at[:, 0].add(burdens.downhill(masses, person.burden))
        if setup.physics.actuators != "unlimited":
            told = strength.of_share(
                setup.physics.actuators, person.ratio, person.burden.strength, told, rates
            )
    if walker.effort is not None:
        power = jnp.sum(jnp.maximum(told * rates, 0.0))
        share = setup.timestep / person.gait.duration_nominal
        walker = walker.replace(effort=walker.effort + share * (power - walker.effort))
    if walker.drives is None:
        return walker, where.control(told), loads
    motors, torques = drives.tick(
        setup.physics,
        where,
        person.ratio,
        person.gait,
        walker.gait,
        anthropometry.about_joint(reference_body(setup).foot) * person.ratio.inertia,
        walker.drives,
        told,
        walker.plant,
    )
    return walker.replace(drives=motors), torques, loads


def noise(walker: Walker, ticks: int) -> Float[Array, "{ticks} 18"]:
    """[ticks, 18] the instruments' white noise of its next ticks.

    Drawn ahead for many ticks it costs little; drawn tick by tick, a sixth of the whole loop.
    """
    return jax.vmap(lambda tick: sensors.white(jax.random.fold_in(walker.key, tick)))(
        walker.tick + jnp.arange(ticks)
    )


def tick(
    setup: Setup, model: engine.Model, walker: Walker, white: Float[Array, "18"] | None = None
) -> tuple[Walker, Event]:
    """One physics step of the closed loop.

    Args:
      white: this tick's row of `noise`, if it was drawn ahead.
    """
    walker, control, loads = drive(setup, walker)
    plant, readings = engine.move(
        setup, model, walker.person.ratio, walker.person.burden, walker.plant, control, loads
    )
    return advance(setup, walker, plant, readings, noise(walker, 1)[0] if white is None else white)


def advance(
    setup: Setup,
    walker: Walker,
    plant: physics.Plant,
    readings: physics.Readings,
    white: Float[Array, "18"],
) -> tuple[Walker, Event]:
    """What becomes of ``walker`` whose plant a tick has brought to ``plant``, sensing ``readings``.

    At a touch-down the step's clock restarts and toe-off begins; the step's
    length and duration stay the last ones until `decide`, which early swing awaits.

    Args:
      white: this tick's row of `noise`.
    """
    person = walker.person
    bones = skeleton(setup, person)
    if person.burden is not None:
        readings = readings.replace(up=burdens.upright(readings.up, person.burden))
    state, estimate = sensors.measure(setup.sensors, setup.timestep, walker.sensors, readings, white)
    late = walker.late
    if person.burden is not None and late is not None:
        late, estimate = latency.tick(setup.timestep, person.burden.delay, late, estimate)

    clock = walker.gait.replace(elapsed=walker.gait.elapsed + setup.timestep)
    after_tick, landed = forms.of(person.gait).proceed(setup, person, bones, clock, estimate)
    event_length = step_clock.step_length(bones, clock, estimate)
    after = walker.replace(
        plant=plant,
        sensors=state,
        estimate=estimate,
        gait=after_tick,
        tick=walker.tick + 1,
        walls=readings.walls,
        late=late,
    )
    finite = jnp.isfinite(_total((walker, plant)))
    fell = has_fallen(setup, after) | ~finite
    return after, Event(
        touchdown=landed & ~fell,
        fell=fell,
        broken=~finite,
        step_length=event_length,
        step_seconds=clock.elapsed,
    )
