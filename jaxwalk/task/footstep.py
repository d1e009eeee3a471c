"""One footstep as one decision: what the policy is told, what it may answer, what it earns."""

from __future__ import annotations

from collections.abc import Callable

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from jaxwalk.config import GRAVITY, RewardConfig
from jaxwalk.control import posture, sensors, step_clock
from jaxwalk.control.person import Person, reference_body, skeleton
from jaxwalk.control.walker import Walker
from jaxwalk.model.engine import Setup

ACTIONS = ("length", "duration")

# Boulic et al. 1990: stride frequency and length grow with the square root of speed over
# hip height; at 1 m/s and 1.8 m the step is 0.633 m.
_BOULIC = 0.633
# Scales of the reward's squares.
_SPEED, _PITCH, _ZMP, _LENGTH, _WORK = 0.5, 0.2, 0.3, 0.3, 0.1

_Seen = Callable[[Setup, Walker, Float[Array, ""]], Float[Array, ""]]


def _zmp(setup: Setup, state: Walker) -> Float[Array, ""]:
    bones = skeleton(setup, state.person)
    return sensors.zmp_distance(bones, state.estimate, state.gait.is_stance) / state.person.ratio.length


def _com_ahead(setup: Setup, state: Walker) -> Float[Array, ""]:
    bones = skeleton(setup, state.person)
    ahead, _ = sensors.com_ahead(bones, state.estimate, state.gait.is_stance)
    return ahead / state.person.ratio.length


def _capture_ahead(setup: Setup, state: Walker) -> Float[Array, ""]:
    where = posture.of(skeleton(setup, state.person), state.estimate)
    return (where.capture - where.ankle[state.gait.stance]) / state.person.ratio.length


def _delay(state: Walker) -> Float[Array, ""]:
    burden = state.person.burden
    return jnp.asarray(0.0 if burden is None else burden.delay) / state.person.ratio.time


def _swing_ahead(setup: Setup, state: Walker) -> Float[Array, ""]:
    bones = skeleton(setup, state.person)
    return step_clock.step_length(bones, state.gait, state.estimate) / state.person.ratio.length


# Everything is told as the reference body would feel it (dynamic similarity).
_OBSERVABLES: dict[str, _Seen] = {
    "speed": lambda setup, w, length: w.estimate.speed / w.person.ratio.speed,
    "pitch": lambda setup, w, length: w.estimate.pitch,
    "zmp": lambda setup, w, length: _zmp(setup, w),
    "step_length": lambda setup, w, length: length / w.person.ratio.length,
    "pitch_rate": lambda setup, w, length: w.estimate.pitch_rate / w.person.ratio.rate,
    "acceleration": lambda setup, w, length: w.estimate.acceleration,
    "speed_desired": lambda setup, w, length: w.person.gait.speed_desired / w.person.ratio.speed,
    "height": lambda setup, w, length: w.person.ratio.length,
    "com_ahead": lambda setup, w, length: _com_ahead(setup, w),
    "elapsed": lambda setup, w, length: w.gait.elapsed / w.person.ratio.time,
    "capture_ahead": lambda setup, w, length: _capture_ahead(setup, w),
    "swing_ahead": lambda setup, w, length: _swing_ahead(setup, w),
    "delay": lambda setup, w, length: _delay(w),
}


def observe(
    names: tuple[str, ...], setup: Setup, state: Walker, length: Float[Array, ""]
) -> Float[Array, "O"]:
    """What the policy is told: sensor values only, scaled to the reference body (m, s, rad).

    Args:
      names: of the observables, in order.
      length: of the step that just ended, from the encoders, m.
    """
    return jnp.stack([jnp.asarray(_OBSERVABLES[name](setup, state, length), jnp.float32) for name in names])


def bounds(person: Person) -> tuple[Float[Array, "2"], Float[Array, "2"]]:
    """What a walker's least and greatest actions stand for: see `GaitConfig.answers`."""
    low, high = (jnp.stack([jnp.asarray(x) for x in one]) for one in person.gait.answers)
    return low, high


def to_command(person: Person, action: Float[Array, "2"]) -> Float[Array, "2"]:
    """From an action in [-1, 1] to (length m, duration s) of the step, or of the change of its plan."""
    low, high = bounds(person)
    return low + 0.5 * (jnp.clip(action, -1.0, 1.0) + 1.0) * (high - low)


def to_action(person: Person, command: Float[Array, "2"]) -> Float[Array, "2"]:
    """The action in [-1, 1] that `to_command` makes ``command`` of."""
    low, high = bounds(person)
    return 2.0 * (command - low) / (high - low) - 1.0


def nominal_action(person: Person) -> Float[Array, "2"]:
    """The answer before learning: the step of the height-to-stride-length ratio, or a plan left as it is."""
    numbers = person.gait
    if numbers.steps == "planned":
        return jnp.zeros(2)
    return to_action(
        person, jnp.stack([jnp.asarray(numbers.length_nominal), jnp.asarray(numbers.duration_nominal)])
    )


def reward(
    config: RewardConfig,
    setup: Setup,
    state: Walker,
    speed: Float[Array, ""],
    length: Float[Array, ""],
    fell: Bool[Array, ""],
) -> Float[Array, ""]:
    """What a footstep earns: exp(-cost), the cost being weighted squares of the state's variables.

    Between 0 and 1, so that to keep walking, however badly, is always better than to fall.

    Args:
      state: at the footstep's end.
      speed: the torso's mean forward speed, over the footstep or about as long, m/s.
      length: of the step, m.
      fell: it ended in a fall.
    """
    ratio = state.person.ratio
    desired = state.person.gait.speed_desired
    usual = _BOULIC * jnp.sqrt(desired / ratio.speed) * ratio.length
    off = jnp.maximum(jnp.abs(speed - desired) - config.speed_tolerance, 0.0)
    cost = (
        config.speed_weight * (off / _SPEED) ** 2
        + config.pitch_weight * (state.estimate.pitch / _PITCH) ** 2
        + config.zmp_weight * (_zmp(setup, state) / _ZMP) ** 2
        + config.length_weight * ((length - usual) / (_LENGTH * ratio.length)) ** 2
    )
    if state.effort is not None:
        weight = GRAVITY * reference_body(setup).mass * ratio.mass
        cost += config.work_weight * (state.effort / (weight * desired) / _WORK) ** 2
    # A fall's own variables are arbitrary (a torso on its way down): it costs a constant.
    return jnp.where(fell, config.fall, jnp.exp(-cost))
