"""Footstep rules without learning, to judge a learned policy against; on compliant legs.

Each rule is a frozen dataclass of constants and a pure function from the raw observation (scaled to
the reference body, see `jaxwalk.task.footstep.observe`) to the commanded (length m, duration s) of the
reference body. Their constants were found on the training physics by ``scripts/tune_baselines.py``,
by the score that settles between a run's best policies.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TypeVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.config import GRAVITY, REFERENCE_HEIGHT, REFERENCE_MASS, Config, GaitConfig, Observable
from jaxwalk.control.person import Person
from jaxwalk.task import footstep

Number = float | Float[Array, ""]  # a constant, or the traced one that is being tuned

OBSERVATION: tuple[Observable, ...] = ("speed", "speed_desired", "com_ahead")

T = TypeVar("T")


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Constant:
    """A step that is never adapted: the best mean survival that a short search found."""

    length: Number = 0.8426
    """Commanded step length, m."""
    duration: Number = 0.4631
    """Commanded duration, s."""

    def command(self, observation: Float[Array, "O"]) -> Float[Array, "2"]:
        """The same for every observation."""
        return jnp.stack([jnp.asarray(self.length), jnp.asarray(self.duration)])


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Raibert:
    """Step length from the error of speed: Raibert, Legged Robots That Balance, 1986, ch. 2.

    The foot is placed at x_f = v T_s / 2 + k (v - v_desired) ahead of the hip. The neutral point
    v T_s / 2 is linear in v: its value in undisturbed walking is part of ``length``, its slope of ``gain``.
    """

    length: Number = 0.8337
    """Commanded step length of undisturbed walking, m."""
    duration: Number = 0.4583
    """Commanded duration, s."""
    gain: Number = -0.06088
    """Length for each m/s too fast, s."""
    landing_speed: Number = 1.33
    """Speed at an undisturbed touch-down, the step's fastest moment, for each m/s desired."""

    def command(self, observation: Float[Array, "O"]) -> Float[Array, "2"]:
        """length + gain (v - v_desired), at the touch-down's own speeds."""
        speed, desired, _ = observation
        length = self.length + self.gain * (speed - self.landing_speed * desired)
        return jnp.stack([length, jnp.asarray(self.duration)])


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class CapturePoint:
    """Step length and time from the divergent component of motion (the instantaneous capture point).

    xi = x + v / w0, w0 = sqrt(g / z), runs away from the foot u it stands on: after T s it is at
    u + b exp(w0 T), b = xi - u at touch-down (Koolen et al. 2012, eq. 6; Englsberger et al. 2015). A
    step of length L leaves the next foot with the offset b exp(w0 T) - L, which shall be that of steady
    walking, b0 = L0 / (exp(w0 T0) - 1). With tau = exp(w0 T) that is linear, L = b tau - b0, and of all
    (L, tau) that obey, the one nearest to steady walking is taken, as in Khadiv et al. 2016, without
    their bounds, which the command's own stand for:

        min ((L - L0) / L0)^2 + timing ((tau - tau0) / tau0)^2   subject to   L = b tau - b0

    The real walker lands on a leg that still loses and gains speed, so b is its deviation from the
    undisturbed touch-down's, added to b0. The command asks for more than the step turns out to be;
    two gains carry the changes of (L, T) to it.
    """

    length: Number = 0.8426
    """Commanded step length of undisturbed walking, m."""
    duration: Number = 0.4631
    """Commanded duration of undisturbed walking, s."""
    length_gain: Number = 0.1
    """Commanded length for each m that the step shall be longer."""
    duration_gain: Number = 0.0
    """Commanded duration for each s that the step shall last longer."""
    timing: Number = 1.0
    """Price of a change of time against one of length: 0 changes the time only."""
    step: Number = 0.6915
    """L0: how long an undisturbed step really is, m."""
    seconds: Number = 0.6997
    """T0: how long it lasts, s."""
    com_ahead: Number = -0.2829
    """The torso's centre ahead of the landed foot at an undisturbed touch-down, m."""
    landing_speed: Number = 1.33
    """Speed at an undisturbed touch-down for each m/s desired."""
    height: Number = 1.0
    """z: of the body's centre of mass, m."""

    def command(self, observation: Float[Array, "O"]) -> Float[Array, "2"]:
        """The step that brings the offset back to that of steady walking."""
        speed, desired, ahead = observation
        omega = jnp.sqrt(GRAVITY / self.height)
        growth = jnp.exp(omega * self.seconds)
        steady = self.step / (growth - 1.0)
        error = ahead - self.com_ahead + (speed - self.landing_speed * desired) / omega
        length, time = self._step(steady + error, steady, growth)
        return jnp.stack(
            [
                self.length + self.length_gain * (length - self.step),
                self.duration + self.duration_gain * (time / omega - self.seconds),
            ]
        )

    def _step(
        self, offset: Float[Array, ""], steady: Float[Array, ""], growth: Float[Array, ""]
    ) -> tuple[Float[Array, ""], Float[Array, ""]]:
        """(L, w0 T) of the problem above, which has one unknown once L is put in."""
        a, b = 1.0 / self.step**2, self.timing / growth**2
        tau = (a * offset * (steady + self.step) + b * growth) / (a * offset**2 + b)
        tau = jnp.maximum(tau, 1.0)  # no step ends before it begins
        return offset * tau - steady, jnp.log(tau)


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Replan:
    """The step that compliant legs plan by themselves at every tick, left as it is: see
    `jaxwalk.control.compliant.step_plan`, whose numbers are the configuration's."""

    def command(self, observation: Float[Array, "O"]) -> Float[Array, "2"]:
        """No change of it."""
        return jnp.zeros(2)


Rule = Constant | Raibert | CapturePoint | Replan

RULES: dict[str, Rule] = {
    "constant": Constant(),
    "raibert": Raibert(),
    "capture-point": CapturePoint(),
    "replan": Replan(),
}
"""On compliant legs."""


def configured(config: Config, rule: Rule) -> Config:
    """``config`` with who settles a step, and what ``rule`` is told; it is asked at touch-downs alone."""
    gait = dataclasses.replace(config.gait, steps="planned" if isinstance(rule, Replan) else "told")
    task = dataclasses.replace(config.task, replan=0)
    return dataclasses.replace(config, gait=gait, observation=OBSERVATION, task=task)


def strong(tree: T) -> T:
    """``tree`` with float32 scalars in place of Python's numbers, so that no program is made twice."""
    return jax.tree.map(lambda x: jnp.asarray(x, jnp.float32), tree)


def reference(gait: GaitConfig) -> Person:
    """The reference body, whose commands the rules speak of."""
    return Person.of(gait, jnp.float32(REFERENCE_HEIGHT), jnp.float32(REFERENCE_MASS))


def act(params: tuple[Rule, Person], observation: Float[Array, "O"]) -> Float[Array, "2"]:
    """A rule's action in [-1, 1] for a raw observation.

    Args:
      params: the rule, and the reference body's numbers (`reference`), whose bounds actions are shares of.
    """
    rule, person = params
    return jnp.clip(footstep.to_action(person, rule.command(observation)), -1.0, 1.0)


def never_adapted(action: Float[Array, "2"], observation: Float[Array, "O"]) -> Float[Array, "2"]:
    """The same ``action`` for every observation."""
    return action


def nominal(config: Config) -> Float[Array, "2"]:
    """The answer before learning of the configured body, as an action."""
    body = config.body
    return jax.jit(lambda h, m: footstep.nominal_action(Person.of(config.gait, h, m)))(
        jnp.float32(body.height), jnp.float32(body.mass)
    )
