"""A walker that takes decisions: its footstep under way, and how that one ends."""

from __future__ import annotations

from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp
from flax import struct
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from jaxwalk.config import Config, Engine, GaitConfig, RewardConfig
from jaxwalk.control import walker
from jaxwalk.control.person import Person, model_of
from jaxwalk.control.walker import Walker
from jaxwalk.kernels import fused as kernels
from jaxwalk.model import engine, pushes
from jaxwalk.model.burdens import Burden
from jaxwalk.model.engine import Setup
from jaxwalk.task import footstep, privileged
from jaxwalk.task.transition import Transition


@dataclass(frozen=True)
class Task:
    """What is decided and rewarded; static under jit.

    Attributes:
      setup: of the walkers.
      observation: names of the observables.
      reward: its weights.
      gamma: discount of a footstep that did not end in a fall.
      episode_ticks: after these the next touch-down is the last (truncation).
      replan: windows after which the step under way is decided anew; 0: never.
      privileged: observations go on with what a critic is told besides (`privileged.told`).
    """

    setup: Setup
    observation: tuple[str, ...]
    reward: RewardConfig
    gamma: float
    episode_ticks: int
    replan: int = 0
    privileged: bool = False

    @classmethod
    def of(cls, config: Config, engine: Engine = "mjx") -> Task:
        """The task of ``config``, whose walkers ``engine`` moves."""
        ticks = round(config.train.episode_seconds / config.physics.timestep)
        setup, gamma, replan = Setup.of(config, engine), config.ddpg.gamma, config.task.replan
        return cls(setup, config.observation, config.reward, gamma, ticks, replan)

    def endless(self) -> Task:
        """The same walk, which no time ends, and of which nobody looks at what is earned: one program serves
        whatever was trained for."""
        return replace(self, reward=RewardConfig(), gamma=1.0, episode_ticks=pushes.NEVER)


class Footstep(struct.PyTreeNode):
    """How a footstep ended; meaningful where ``closed``.

    Attributes:
      closed: a decided footstep ended since the slot was last emptied.
      transition: it, with raw observations; its discount is 0 after a fall.
      length: m. seconds: s. speed: mean of the torso over it, m/s.
    """

    closed: Bool[Array, ""]
    transition: Transition
    length: Float[Array, ""]
    seconds: Float[Array, ""]
    speed: Float[Array, ""]


class Interval(struct.PyTreeNode):
    """What has been since the last answer, of a walker that is asked again within the step.

    Attributes:
      windows: decision windows. landed: a foot has.
      pace: the estimated speed, averaged over about the time of a nominal step, whenever answers came, m/s:
        that of a part of a step says where in the step it is.
    """

    windows: Int[Array, ""]
    landed: Bool[Array, ""]
    pace: Float[Array, ""]


class Stepper(struct.PyTreeNode):
    """A walker and the decision it lives under.

    Attributes:
      walker: the body and its controllers.
      asked: a decision is awaited.
      decided: the footstep under way has one.
      observation: [O] as it was asked last: at the touch-down, or at a window's end.
      action: [2] the decision, in [-1, 1].
      speed_sum: of the estimated speed over the ticks of the footstep, m/s.
      last: the footstep that ended last.
      terminated: fell, stalled or broke; nothing moves any more.
      truncated: its time is over; likewise.
      broken: a number of its state was not finite; what led there is kept out of ``last``.
      interval: since the last answer; None where steps are never decided anew.
    """

    walker: Walker
    asked: Bool[Array, ""]
    decided: Bool[Array, ""]
    observation: Float[Array, "O"]
    action: Float[Array, "2"]
    speed_sum: Float[Array, ""]
    last: Footstep
    terminated: Bool[Array, ""]
    truncated: Bool[Array, ""]
    broken: Bool[Array, ""]
    interval: Interval | None = None

    @property
    def done(self) -> Bool[Array, "..."]:
        """Whether nothing more comes: terminated or truncated."""
        return self.terminated | self.truncated


def select(condition: Bool[Array, ""], new, old):
    """``new`` where the scalar ``condition`` holds, else ``old``, leaf by leaf; keys included."""
    return jax.tree.map(lambda a, b: jnp.where(condition, a, b), new, old)


def _observed(task: Task, state: Walker, length: Float[Array, ""]) -> Float[Array, "O"]:
    seen = footstep.observe(task.observation, task.setup, state, length)
    return jnp.concatenate([seen, privileged.told(task.setup, state)]) if task.privileged else seen


def start(
    task: Task,
    numbers: GaitConfig,
    height: Float[Array, ""],
    mass: Float[Array, ""],
    noise: Float[Array, ""],
    key: PRNGKeyArray,
    burden: Burden | None = None,
) -> Stepper:
    """A new walker whose front foot has just landed, so that its first decision is due."""
    person = Person.of(numbers, height, mass, burden)
    state = walker.start(task.setup, person, key, noise)
    length = walker.landed_length(task.setup, state)
    observation = _observed(task, state, length)
    zero, false = jnp.zeros(()), jnp.bool_(False)
    action = footstep.nominal_action(person)
    empty = Transition(
        observation=observation, action=action, reward=zero, discount=zero, next_observation=observation
    )
    return Stepper(
        walker=state,
        asked=jnp.bool_(True),
        decided=false,
        observation=observation,
        action=action,
        speed_sum=zero,
        last=Footstep(false, empty, length, zero, zero),
        terminated=false,
        truncated=false,
        broken=false,
        interval=Interval(jnp.int32(0), false, state.estimate.speed) if task.replan else None,
    )


def decide(stepper: Stepper, action: Float[Array, "2"]) -> Stepper:
    """Answer the touch-down that asked; a stepper that did not ask is left alone."""
    decided = stepper.replace(
        walker=walker.decide(stepper.walker, footstep.to_command(stepper.walker.person, action)),
        action=jnp.clip(action, -1.0, 1.0),
        asked=jnp.bool_(False),
        decided=jnp.bool_(True),
    )
    return select(stepper.asked, decided, stepper)


def tick(
    task: Task, model: engine.Model, stepper: Stepper, white: Float[Array, "18"] | None = None
) -> Stepper:
    """One physics step; at a touch-down or a fall the footstep closes into ``last``.

    A walker that is done stays as it is.

    Args:
      model: `model_of` of it; kernels make their own of who the walker is.
      white: as for `walker.tick`.
    """
    white = walker.noise(stepper.walker, 1)[0] if white is None else white
    setup = task.setup
    # Gazebo's drives round to whole ticks, which has no kernel, and compliant legs have not been tried on a
    # GPU; the plant of both has kernels (`engine.move`).
    servos = setup.engine == "mjx" and setup.physics.drives == "servo"
    if servos and engine.on_gpu(setup):
        return kernels.fused(_tick, task, stepper, white)
    return advance(task, stepper, *walker.tick(task.setup, model, stepper.walker, white))


def _tick(task: Task, stepper: Stepper, white: Float[Array, "18"]) -> Stepper:
    model = model_of(task.setup, stepper.walker.person)
    return advance(task, stepper, *walker.tick(task.setup, model, stepper.walker, white))


def alone(task: Task, stepper: Stepper) -> tuple[Stepper, None]:
    """One physics step of a walker that brings along all that it needs, noise and body included."""
    return _tick(task, stepper, walker.noise(stepper.walker, 1)[0]), None


def advance(task: Task, stepper: Stepper, state: Walker, event: walker.Event) -> Stepper:
    """What becomes of ``stepper`` whose walker a tick has made ``state``; see `tick`."""
    seconds = jnp.maximum(event.step_seconds, task.setup.timestep)
    speed_sum = stepper.speed_sum + state.estimate.speed
    speed = speed_sum * task.setup.timestep / seconds
    asks, interval, share, mean = event.touchdown, None, None, speed
    length = event.step_length
    if stepper.interval is not None:
        asks, interval, share, mean = _since(task, stepper.interval, state, event)
        length = jnp.where(event.touchdown, length, stepper.last.length)
    observation = _observed(task, state, length)
    earned = footstep.reward(task.reward, task.setup, state, mean, length, event.fell)
    discount = jnp.float32(task.gamma)
    if share is not None:
        earned = jnp.where(event.fell, earned, earned * share)
        discount = discount**share
    closed = Footstep(
        closed=jnp.bool_(True),
        transition=Transition(
            observation=stepper.observation,
            action=stepper.action,
            reward=earned,
            discount=jnp.where(event.fell, 0.0, discount),
            next_observation=observation,
        ),
        length=event.step_length,
        seconds=seconds,
        speed=speed,
    )
    ends = (asks | event.fell) & stepper.decided & ~event.broken
    # A fall before the last touch-down was answered is the doing of the footstep that just closed.
    undecided = event.fell & ~stepper.decided & ~event.broken
    blamed = stepper.last.replace(
        transition=replace(stepper.last.transition, reward=earned, discount=jnp.zeros(()))
    )
    last = select(ends, closed, select(undecided, blamed, stepper.last))
    if interval is not None:  # a footstep ends at its landing, whenever what is decided ends
        landing = (event.touchdown | event.fell) & ~event.broken
        told = [(getattr(closed, name), getattr(stepper.last, name)) for name in _LANDING]
        kept = {name: jnp.where(landing, *x) for name, x in zip(_LANDING, told, strict=True)}
        last = last.replace(**kept)
    moved = stepper.replace(
        walker=select(event.broken, stepper.walker, state),
        asked=stepper.asked | asks,
        decided=stepper.decided & ~asks,
        observation=jnp.where(asks, observation, stepper.observation),
        speed_sum=jnp.where(event.touchdown, 0.0, speed_sum),
        last=last,
        terminated=event.fell,
        truncated=asks & (state.tick >= task.episode_ticks),
        broken=event.broken,
        interval=interval,
    )
    return select(stepper.done, stepper, moved)


_LANDING = ("length", "seconds", "speed")


def _since(
    task: Task, before: Interval, state: Walker, event: walker.Event
) -> tuple[Bool[Array, ""], Interval, Float[Array, ""], Float[Array, ""]]:
    """Whether the walker asks, since the tick just made: at the end of a window in which it has landed, or
    when the last answer is old; the interval that goes on or begins; how long the last one was, as a share of
    a nominal step; and the pace, m/s.
    """
    setup = task.setup
    ends = state.tick % setup.window_ticks == 0
    windows = before.windows + ends.astype(jnp.int32)
    landed = before.landed | event.touchdown
    nominal = state.person.gait.duration_nominal
    pace = before.pace + setup.timestep / nominal * (state.estimate.speed - before.pace)
    asks = ends & (landed | (windows >= task.replan)) & ~event.fell
    over = jnp.maximum(windows.astype(jnp.float32), 1.0) * setup.window_ticks
    interval = Interval(
        windows=jnp.where(asks, 0, windows),
        landed=landed & ~asks,
        pace=pace,
    )
    return asks, interval, over * setup.timestep / nominal, pace
