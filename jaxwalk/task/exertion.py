"""What a walk costs and how hard it lands, counted as it is walked: what a search for a gait needs of
thousands of walkers, of whom the gait laboratory would keep every tick."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
from flax import struct
from jaxtyping import Array, Float

from jaxwalk.control import walker
from jaxwalk.control.person import model_of
from jaxwalk.task import stepper, trials
from jaxwalk.task.stepper import Task
from jaxwalk.task.trials import SETTLE_SECONDS, Profile, Trial

LOADING_SECONDS = 0.18  # after touch-down, in which the knee yields
CONTACT_FORCE = 20.0  # N under a sole that stands


class Exertion(struct.PyTreeNode):
    """One walker's, from `SETTLE_SECONDS` on; of joints moved by torques.

    Attributes:
      joint_work, leg_work: positive work, summed over joints, or over legs whose joints may exchange it, J.
      force: largest of both soles together, N.
      hip_moment: largest, N m. hip_power: largest, W.
      pitch_high, pitch_low: of the torso, rad.
      loading: sum over steps of the largest flexion of the stance knee as it takes the load, rad.
      loading_now: of the step under way.
      standing, standing_now: the same of its smallest flexion.
      passing: largest flexion of a swinging knee, rad. dorsiflexion: of a swinging ankle, rad.
      double: time on both feet, s.
    """

    joint_work: Float[Array, ""]
    leg_work: Float[Array, ""]
    force: Float[Array, ""]
    hip_moment: Float[Array, ""]
    hip_power: Float[Array, ""]
    pitch_high: Float[Array, ""]
    pitch_low: Float[Array, ""]
    loading: Float[Array, ""]
    loading_now: Float[Array, ""]
    standing: Float[Array, ""]
    standing_now: Float[Array, ""]
    passing: Float[Array, ""]
    dorsiflexion: Float[Array, ""]
    double: Float[Array, ""]


class Tried(struct.PyTreeNode):
    """A walker on trial, with what it exerts."""

    trial: Trial
    exertion: Exertion


def begin(trial: Trial) -> Tried:
    """Nothing counted yet."""
    zero, high = jnp.zeros(()), jnp.float32(jnp.inf)
    none = Exertion(zero, zero, zero, zero, zero, -high, high, *(zero,) * 7)
    return Tried(trial, none)


def alone(task: Task, tried: Tried, profile: Profile) -> tuple[Tried, None]:
    """One tick of a walker that brings along all that it needs."""
    return tick(task, tried, profile), None


def tick(task: Task, tried: Tried, profile: Profile) -> Tried:
    """One tick."""
    before = tried.trial.state.walker
    model, white = model_of(task.setup, before.person), walker.noise(before, 1)[0]
    _, torque, _ = walker.drive(task.setup, before)
    trial = trials.tick(task, profile, model, tried.trial, white)
    exertion = _count(task, tried.exertion, trial, torque[:6])
    return Tried(trial, stepper.select(tried.trial.state.done, tried.exertion, exertion))


def _count(task: Task, sums: Exertion, trial: Trial, torque: Float[Array, "6"]) -> Exertion:
    body, dt = trial.state.walker, task.setup.timestep
    counts = (body.tick * dt > SETTLE_SECONDS).astype(jnp.float32)
    estimate, pitch = body.estimate, body.plant.qpos[2]
    rates = estimate.joint_rates.reshape(6)
    power = torque * rates
    legs = power.reshape(2, 3)
    landed = body.gait.elapsed == 0
    knee = estimate.joints[body.gait.stance, 1]
    loading = body.gait.elapsed < LOADING_SECONDS
    now = jnp.where(landed, knee, jnp.where(loading, jnp.maximum(sums.loading_now, knee), sums.loading_now))
    both = (estimate.touch[0] > CONTACT_FORCE) & (estimate.touch[1] > CONTACT_FORCE)

    def most(old: Float[Array, ""], new: Any) -> Float[Array, ""]:
        return jnp.maximum(old, counts * new)

    return Exertion(
        joint_work=sums.joint_work + counts * dt * jnp.sum(jnp.maximum(power, 0.0)),
        leg_work=sums.leg_work + counts * dt * jnp.sum(jnp.maximum(jnp.sum(legs, axis=1), 0.0)),
        force=most(sums.force, jnp.sum(estimate.touch)),
        hip_moment=most(sums.hip_moment, jnp.max(jnp.abs(torque.reshape(2, 3)[:, 0]))),
        hip_power=most(sums.hip_power, jnp.max(legs[:, 0])),
        pitch_high=jnp.where(counts > 0, jnp.maximum(sums.pitch_high, pitch), sums.pitch_high),
        pitch_low=jnp.where(counts > 0, jnp.minimum(sums.pitch_low, pitch), sums.pitch_low),
        loading=sums.loading + jnp.where(landed, counts * sums.loading_now, 0.0),
        loading_now=now,
        standing=sums.standing + jnp.where(landed, counts * sums.standing_now, 0.0),
        standing_now=jnp.where(landed, knee, jnp.minimum(sums.standing_now, knee)),
        passing=most(sums.passing, estimate.joints[1 - body.gait.stance, 1]),
        dorsiflexion=most(sums.dorsiflexion, estimate.joints[1 - body.gait.stance, 2]),
        double=sums.double + counts * dt * both,
    )
