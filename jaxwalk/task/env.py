"""The walker as a Brax environment, one footstep a step.

Importing this module registers it: ``brax.envs.get_environment("jaxwalk_footstep")``. A step
runs until the touch-down, so a batch waits for its slowest walker; the trainer's windows
(`jaxwalk.task.collect`) do not, and bring the same transitions.
"""

from __future__ import annotations

import dataclasses
from typing import NoReturn, cast

import jax
import jax.numpy as jnp
from brax import envs
from brax.envs.base import Env, State
from jaxtyping import Array, Float, PRNGKeyArray

from jaxwalk.common import runtime
from jaxwalk.common.errors import UserError
from jaxwalk.config import Config, validate
from jaxwalk.control.person import model_of
from jaxwalk.task import backend, footstep, spawn, stepper
from jaxwalk.task.stepper import Stepper, Task

NAME = "jaxwalk_footstep"
TICKS = 25  # at most, that native code goes on before it is asked whether a walker awaits its decision


class FootstepEnv(Env):
    """One walker; `reset` and `step` are pure and may be jitted and vmapped.

    ``state.pipeline_state`` is the `Stepper`, ``state.obs`` the raw observation [O] of
    ``config.observation``, an action [2] is (length, duration) of the step, or of the
    change of its plan, each in [-1, 1].

    ``state.done`` is 1.0 after a fall, a stall or a state that is not finite; time that is over
    is ``info["truncation"]`` 1.0, and the walker walks on if it is stepped nevertheless.
    ``info["final_observation"]`` [O] is the observation with which the footstep ended, also where
    Brax's ``AutoResetWrapper`` has put the next episode's first one into ``obs``. Brax's
    ``EpisodeWrapper`` counts decisions and writes its own truncation. ``metrics``: ``speed`` (m/s),
    ``step_length`` (m) and ``step_seconds`` (s) of the footstep, and whether it ``fell`` or was
    ``broken`` (not finite).

    Args:
      config: who walks, what is seen and rewarded, which pushes come; the default preset if None.
      backend: as Brax's callers name it; there is one.

    Raises:
      UserError: a value of ``config`` is out of range, or another backend.
    """

    def __init__(self, config: Config | None = None, backend: str = "mjx") -> None:
        if backend != self.backend:
            raise UserError(f"backend {backend!r}: give {self.backend}, or leave it out")
        self.config = Config() if config is None else config
        validate.check(self.config)
        self._task = Task.of(self.config)

    @property
    def observation_size(self) -> int:
        """O, numbers of an observation."""
        return len(self.config.observation)

    @property
    def action_size(self) -> int:
        """Numbers of an action: length and duration."""
        return len(footstep.ACTIONS)

    @property
    def dt(self) -> float:
        """Seconds that a step lasts, as a rule: a nominal footstep, or until the next decision is due."""
        task = self._task
        if not task.replan:
            return self.config.gait.duration_nominal
        return task.replan * task.setup.window_ticks * task.setup.timestep

    @property
    def sys(self) -> NoReturn:
        """Brax's system, which there is none of.

        Raises:
          AttributeError: always; it says what is there instead.
        """
        raise AttributeError(
            "FootstepEnv has no sys, and takes no randomization_fn: give config.train.height_spread, "
            "mass_spread and config.circumstances; jaxwalk render draws it"
        )

    @property
    def backend(self) -> str:
        """What moves the body, as Brax asks of its environments."""
        return "mjx"

    @runtime.in_float32()
    def reset(self, rng: Array) -> State:
        """A new walker as training meets them, whose front foot has just landed.

        Args:
          rng: a key, or the [2] raw numbers of one, as Brax passes it.
        """
        key = rng if jnp.issubdtype(rng.dtype, jax.dtypes.prng_key) else jax.random.wrap_key_data(rng)
        spawn_key, key = jax.random.split(key)
        # One type for each leaf from reset to the last step, or programs would be traced twice.
        fresh = jax.tree.map(_strong, spawn.walker(self.config, self._task, spawn_key))
        zero = jnp.zeros(())
        return State(
            pipeline_state=fresh,
            obs=fresh.observation,
            reward=zero,
            done=zero,
            metrics=dict(speed=zero, step_length=zero, step_seconds=zero, fell=zero, broken=zero),
            info=dict(rng=key, truncation=zero, final_observation=fresh.observation),
        )

    @runtime.in_float32()
    def step(self, state: State, action: Float[Array, "2"]) -> State:
        """Take one footstep, or as much of it as one decision is for (``config.task.replan``). A walker that
        is done stays so and earns 0."""
        key, renew_key = jax.random.split(state.info["rng"])
        before = self._renew(cast(Stepper, state.pipeline_state), renew_key)
        over = before.done
        after = self._walk(stepper.decide(before, jnp.asarray(action, jnp.float32)))
        last = after.last
        # What is not finite closes no footstep: it costs a fall, and the last sound observation stands.
        reward = jnp.where(last.closed, last.transition.reward, self._task.reward.fall)
        observation = jnp.where(last.closed, last.transition.next_observation, cast(Array, state.obs))
        fell, broken, truncation = (_number(x) for x in (after.terminated, after.broken, after.truncated))
        return dataclasses.replace(
            state,
            pipeline_state=after.replace(truncated=jnp.bool_(False)),
            obs=observation,
            reward=jnp.where(over, 0.0, reward),
            done=fell,
            metrics=state.metrics
            | dict(
                speed=jnp.where(last.closed, last.speed, 0.0),
                step_length=jnp.where(last.closed, last.length, 0.0),
                step_seconds=jnp.where(last.closed, last.seconds, 0.0),
                fell=fell,
                broken=broken,
            ),
            info=state.info | dict(rng=key, truncation=truncation, final_observation=observation),
        )

    def _renew(self, state: Stepper, key: PRNGKeyArray) -> Stepper:
        """The next push where one is over; at an episode's start, push and noise of its own.

        Brax's ``AutoResetWrapper`` begins every episode with the same state, which would bring the
        same pushes and the same noise each time; the key in ``info`` is not set back.
        """
        noise_key, push_key = jax.random.split(key)
        body = state.walker
        begins = body.tick == 0
        over = body.tick >= body.push.start + body.push.ticks
        push = stepper.select(begins | over, spawn.push(self.config, state, push_key), body.push)
        noise_key = stepper.select(begins, noise_key, body.key)
        return state.replace(walker=body.replace(push=push, key=noise_key))

    def _walk(self, state: Stepper) -> Stepper:
        """Walk until the next decision is due, or to the end; a stall ends, so this does."""
        task = self._task
        ticks = min(TICKS, task.setup.window_ticks) if task.replan else TICKS
        state = state.replace(last=state.last.replace(closed=jnp.bool_(False)))

        def on(state: Stepper) -> Stepper:
            def by_xla() -> tuple[Stepper, None]:
                return stepper.tick(task, model_of(task.setup, state.walker.person), state), None

            return backend.scan(task.setup, _on, task, ticks, state, otherwise=by_xla)[0]

        return jax.lax.while_loop(_goes_on, on, state)


def _goes_on(state: Stepper) -> Array:
    return ~(state.asked | state.done)


def _on(task: Task, state: Stepper) -> tuple[Stepper, None]:
    """One tick further, if the footstep goes on."""
    return stepper.select(_goes_on(state), stepper.alone(task, state)[0], state), None


def _strong(leaf: Array | float) -> Array:
    """``leaf`` as an array whose dtype does not yield to others' (JAX calls the opposite weak)."""
    if isinstance(leaf, jax.Array) and jnp.issubdtype(leaf.dtype, jax.dtypes.prng_key):
        return leaf
    return jnp.asarray(leaf, jnp.result_type(leaf))


def _number(flag: Array) -> Array:
    return flag.astype(jnp.float32)


envs.register_environment(NAME, FootstepEnv)
