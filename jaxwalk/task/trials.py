"""Trials: walkers followed one by one, with an optional push at a chosen phase of a step.

One compiled program advances a batch of trials by a segment; walking, push tests and the
evaluations within training all run through it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from operator import itemgetter
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from flax import struct
from jax.sharding import Mesh
from jaxtyping import Array, Bool, Float, Int

from jaxwalk.common import runtime
from jaxwalk.common.parallel import devices
from jaxwalk.config import GaitConfig
from jaxwalk.control import walker
from jaxwalk.control.person import model_of
from jaxwalk.model import engine, pushes
from jaxwalk.task import backend, stepper, sway
from jaxwalk.task.scenarios import Scenario
from jaxwalk.task.stepper import Stepper, Task
from jaxwalk.task.sway import Sway

BINS, BIN_SECONDS = 64, 0.0125  # of the time since touch-down, for the speed's profile
SETTLE_SECONDS = 3.0  # statistics begin after this
PUSH_STEP = 6  # the footstep, counted from the start, in which the push comes
RECOVERED = 0.1  # m/s off the profile, paper's "steady"
OFF_SECONDS = 0.05
TRIAL_BYTES = 50_000  # that one takes while it is advanced, measured on native code
GOES_ON = 0.5  # of the speed asked for

Params = Any  # whatever ``act`` wants
Act = Callable[[Params, Float[Array, "O"]], Float[Array, "2"]]


class Profile(struct.PyTreeNode):
    """The unpushed walk that recovery is held against.

    Attributes:
      speed: [BINS] mean speed of the torso's centre, by the time since touch-down, m/s.
      seconds: mean step duration, s.
    """

    speed: Float[Array, "BINS"]
    seconds: Float[Array, ""]

    @classmethod
    def blank(cls) -> Profile:
        """A profile to go on with where recovery is not asked for, or not known yet."""
        return cls(jnp.zeros(BINS), jnp.float32(0.6))


class Tally(struct.PyTreeNode):
    """What is counted, per trial; sums run from `SETTLE_SECONDS` on.

    Attributes:
      seconds: counted. distance: of the hip, m. pitch: its sum over time, rad s.
      pitch_high, pitch_low: of the footstep under way, rad.
      pitch_swing: sum over footsteps of half the peak-to-peak, rad.
      steps, step_length, step_seconds: footsteps counted, and their sums (m, s).
      longest, shortest: footstep since the push began, m and s.
      speed_sum, speed_count: [BINS] the speed over the step.
      impulse: delivered so far, N s.
      off: how far the speed is off its profile, averaged over about `OFF_SECONDS`, m/s.
      steady: how long that has been within `RECOVERED` since the push, s.
      recovery: from the push's end to being steady for a whole step, s; inf before that.
      fall_seconds: life at the fall; inf while up.
      sway: between walls; None in the plane.
    """

    seconds: Float[Array, ""]
    distance: Float[Array, ""]
    pitch: Float[Array, ""]
    pitch_high: Float[Array, ""]
    pitch_low: Float[Array, ""]
    pitch_swing: Float[Array, ""]
    steps: Float[Array, ""]
    step_length: Float[Array, ""]
    step_seconds: Float[Array, ""]
    longest: Float[Array, ""]
    shortest: Float[Array, ""]
    speed_sum: Float[Array, "BINS"]
    speed_count: Float[Array, "BINS"]
    impulse: Float[Array, ""]
    off: Float[Array, ""]
    steady: Float[Array, ""]
    recovery: Float[Array, ""]
    fall_seconds: Float[Array, ""]
    sway: Sway | None = None


class Trial(struct.PyTreeNode):
    """A walker on trial.

    Attributes:
      scenario: what it is put through.
      state: the walker and its decisions.
      touchdowns: so far.
      tally: what was counted.
    """

    scenario: Scenario
    state: Stepper
    touchdowns: Int[Array, ""]
    tally: Tally


def survived(trials: Trial) -> np.ndarray:
    """[N] of trials on the host: whether each walks on, and met the pushes that were meant for it."""
    scenario = trials.scenario
    times = np.where(np.asarray(scenario.again) > 0, 2, 1)
    met = np.isclose(trials.tally.impulse, times * np.asarray(scenario.impulse), rtol=1e-3)
    return walks_on(trials) & met


def walks_on(trials: Trial) -> np.ndarray:
    """[N] of trials on the host: whether each is up at the end, and took its last step at `GOES_ON` of the
    speed asked for at least: who rocks on the spot for ever, or walks backward, has not got over its push."""
    state = trials.state
    asked = GOES_ON * np.asarray(state.walker.person.gait.speed_desired)
    return ~np.asarray(state.terminated) & (np.asarray(state.last.speed) >= asked)


def begin(task: Task, numbers: GaitConfig, scenario: Scenario) -> Trial:
    """A trial at its start; the push waits for its step."""
    person = (scenario.height, scenario.mass, scenario.noise)
    state = stepper.start(task, numbers, *person, scenario.key, scenario.burden)
    push = pushes.none().replace(
        ticks=scenario.push_ticks,
        force=scenario.impulse / (scenario.push_ticks * task.setup.timestep),
        height=scenario.push_height,
        place=scenario.push_place,
    )
    state = state.replace(walker=state.walker.replace(push=push))
    zero, bins = jnp.zeros(()), jnp.zeros(BINS)
    tally = Tally(
        seconds=zero,
        distance=zero,
        pitch=zero,
        pitch_high=jnp.float32(-jnp.inf),
        pitch_low=jnp.float32(jnp.inf),
        pitch_swing=zero,
        steps=zero,
        step_length=zero,
        step_seconds=zero,
        longest=zero,
        shortest=jnp.float32(jnp.inf),
        speed_sum=bins,
        speed_count=bins,
        impulse=zero,
        off=zero,
        steady=zero,
        recovery=jnp.float32(jnp.inf),
        fall_seconds=jnp.float32(jnp.inf),
        sway=None if state.walker.walls is None else sway.start(),
    )
    return Trial(scenario, state, jnp.int32(0), tally)


def _alone(task: Task, trial: Trial, profile: Profile) -> tuple[Trial, None]:
    """One tick of a trial that brings along all that it needs."""
    body = trial.state.walker
    model, white = model_of(task.setup, body.person), walker.noise(body, 1)[0]
    return tick(task, profile, model, trial, white), None


def tick(task: Task, profile: Profile, model: engine.Model, trial: Trial, white: Float[Array, "18"]) -> Trial:
    """One tick: the walker's, the push that waits for its step, and what is counted.

    Args:
      white: as for `walker.tick`.
    """
    before, dt = trial.state, task.setup.timestep
    after = stepper.tick(task, model, before, white)
    landed = (after.walker.gait.elapsed == 0) & ~after.terminated
    touchdowns = trial.touchdowns + landed.astype(jnp.int32)
    body = after.walker
    # Of a step as long as its last one.
    delay = (trial.scenario.phase * after.last.seconds / dt).astype(jnp.int32)
    due = landed & (touchdowns == PUSH_STEP) & (trial.scenario.impulse != 0)
    again = _comes_again(trial, body)
    start = jnp.where(due, body.tick + delay, jnp.where(again, body.tick, body.push.start))
    after = after.replace(walker=body.replace(push=body.push.replace(start=start)))
    tally = _count(task, profile, trial, before, after, landed)
    tally = tally.replace(recovery=jnp.where(again, jnp.inf, tally.recovery))
    moved = trial.replace(state=after, touchdowns=touchdowns, tally=tally)
    return stepper.select(before.done, trial, moved)


def _comes_again(trial: Trial, body: walker.Walker) -> Bool[Array, ""]:
    """Whether it is time for the second push, and only the first one has been."""
    scenario = trial.scenario
    once = jnp.abs(trial.tally.impulse) < 1.5 * jnp.abs(scenario.impulse)
    return (scenario.again > 0) & (body.tick == body.push.start + scenario.again) & once


def _count(
    task: Task, profile: Profile, trial: Trial, before: Stepper, after: Stepper, landed: Bool[Array, ""]
) -> Tally:
    tally, dt, body = trial.tally, task.setup.timestep, after.walker
    seconds = body.tick * dt
    counted = jnp.round(tally.seconds / dt)  # in whole ticks: to add up 2 ms in float32 drifts within an hour
    counts = (seconds > SETTLE_SECONDS).astype(jnp.float32)
    pitch, speed = body.plant.qpos[2], body.sensors.last_velocity
    place = jnp.clip(body.gait.elapsed / BIN_SECONDS, 0, BINS - 1).astype(jnp.int32)
    here = jnp.arange(BINS) == place

    high, low = jnp.maximum(tally.pitch_high, pitch), jnp.minimum(tally.pitch_low, pitch)
    whole = landed & (counts > 0)
    push, tick = before.walker.push, before.walker.tick
    pushed = tick >= push.start + push.ticks
    answering = landed & (tick >= push.start)
    # A landing a few ticks early is no loss of balance: its spike is averaged away.
    off = tally.off + dt / OFF_SECONDS * (speed - jnp.sum(jnp.where(here, profile.speed, 0.0)) - tally.off)
    steady = jnp.where(pushed & (jnp.abs(off) <= RECOVERED), tally.steady + dt, 0.0)
    since = (tick - push.start - push.ticks) * dt
    recovered = (steady >= profile.seconds) & jnp.isinf(tally.recovery)
    return Tally(
        seconds=(counted + counts) * dt,
        distance=tally.distance + counts * (body.plant.qpos[0] - before.walker.plant.qpos[0]),
        pitch=tally.pitch + counts * pitch * dt,
        pitch_high=jnp.where(landed, pitch, high),
        pitch_low=jnp.where(landed, pitch, low),
        pitch_swing=tally.pitch_swing + jnp.where(whole, 0.5 * (high - low), 0.0),
        steps=tally.steps + whole,
        step_length=tally.step_length + jnp.where(whole, after.last.length, 0.0),
        step_seconds=tally.step_seconds + jnp.where(whole, after.last.seconds, 0.0),
        longest=jnp.where(answering, jnp.maximum(tally.longest, after.last.length), tally.longest),
        shortest=jnp.where(answering, jnp.minimum(tally.shortest, after.last.seconds), tally.shortest),
        speed_sum=tally.speed_sum + counts * jnp.where(here, speed, 0.0),
        speed_count=tally.speed_count + counts * here,
        impulse=tally.impulse + jnp.where(pushes.active(push, tick), push.force * dt, 0.0),
        off=off,
        steady=steady,
        recovery=jnp.where(recovered, jnp.maximum(since - steady, 0.0), tally.recovery),
        fall_seconds=jnp.where(
            after.terminated, jnp.minimum(tally.fall_seconds, seconds), tally.fall_seconds
        ),
        sway=None if tally.sway is None else sway.count(tally.sway, trial.scenario.height, body, counts * dt),
    )


def advance(
    task: Task, act: Act, params: Params, profile: Profile, windows: Int[Array, ""], trial: Trial
) -> Trial:
    """One trial, ``windows`` decision windows further; the policy is asked at each one's start."""
    count = task.setup.window_ticks

    def window(_, trial: Trial) -> Trial:
        answered = stepper.decide(trial.state, act(params, trial.state.observation))
        trial = trial.replace(state=answered)

        def by_xla() -> tuple[Trial, None]:
            body = answered.walker
            model, white = model_of(task.setup, body.person), walker.noise(body, count)
            return jax.lax.fori_loop(
                0, count, lambda i, t: tick(task, profile, model, t, white[i]), trial
            ), None

        return backend.scan(task.setup, _alone, task, count, trial, profile, otherwise=by_xla)[0]

    return jax.lax.fori_loop(0, windows, window, trial)


class Runner:
    """Runs scenarios in batches of one size, so that one program serves them all.

    Args:
      task: what is decided.
      act: the policy on one observation; ``run``'s ``params`` are passed to it.
      batch: trials advanced together; rounded up to whole blocks for each of the devices. On a CPU
        trials are the same, bit for bit, in a batch of any size.
      mesh: of the devices; default all. ``params`` that live on devices must live on these.
      spread: how programs are put on them: `devices.spread`, or `devices.alike` for trials that are the
        same, bit for bit, on any number of devices, too.

    Attributes:
      begin: the program (numbers, scenarios [batch]) -> trials [batch] at their start.
      advance: the program (params, profile, windows, trials [batch]) -> trials, in the same memory.
    """

    def __init__(
        self,
        task: Task,
        act: Act,
        batch: int,
        mesh: Mesh | None = None,
        spread: Callable[..., Callable[..., Any]] = devices.spread,
    ) -> None:
        mesh = devices.mesh() if mesh is None else mesh
        # A trial ends by falling or when it is over, never by an episode's time limit.
        self.task = task = task.endless()
        block = backend.block(task.setup)
        whole = mesh.size * block
        if jax.default_backend() == "cpu":  # which ends the process where memory is short
            batch = min(batch, max(whole, runtime.memory_left() // 2 // TRIAL_BYTES))
        self.batch = -(-batch // whole) * whole
        self._window_seconds = task.setup.timestep * task.setup.window_ticks
        self.begin = spread(
            lambda n, s: devices.each(partial(begin, task, n), s, block=block), mesh, (False, True)
        )
        each = partial(advance, task, act)
        self.advance = spread(
            lambda p, f, w, t: devices.each(lambda one: each(p, f, w, one), t, block=block),
            mesh,
            (False, False, False, True),
        )

    def _segments(self, seconds: float) -> tuple[int, int]:
        """(segments of at most a second, decision windows in each): ``seconds`` or little more."""
        windows = max(1, int(np.ceil(seconds / self._window_seconds - 1e-6)))
        segments = max(1, int(np.ceil(windows * self._window_seconds - 1e-6)))
        return segments, -(-windows // segments)

    def ticks(self, seconds: float) -> int:
        """How many of each trial `run` computes for ``seconds``."""
        segments, windows = self._segments(seconds)
        return segments * windows * self.task.setup.window_ticks

    def run(
        self,
        params: Params,
        numbers: GaitConfig,
        profile: Profile,
        scenarios: Scenario,
        seconds: float,
        tell: Callable[[float], None] = lambda share: None,
    ) -> Trial:
        """Advance [N] scenarios by ``seconds``, rounded up to equal segments of whole windows.

        Args:
          params: the policy's.
          numbers: the controllers'; others of the same kind need no new program.
          profile: what recovery is held against.
          tell: called with the share that is done after each segment.

        Returns:
          The trials [N], on the host.
        """
        count = scenarios.impulse.shape[0]
        parts = -(-count // self.batch)
        segments, windows = self._segments(seconds)
        done = []
        for part in range(parts):
            # The last part is filled up with trials that nobody reads.
            index = np.arange(part * self.batch, (part + 1) * self.batch) % count
            trials = self.begin(numbers, jax.tree.map(itemgetter(index), scenarios))
            for segment in range(segments):
                trials = self.advance(params, profile, jnp.int32(windows), trials)
                jax.block_until_ready(trials.tally.seconds)
                tell((part * segments + segment + 1) / (parts * segments))
            done.append(jax.device_get(without_keys(trials)))
        return jax.tree.map(lambda *x: np.concatenate(x)[:count], *done)


def without_keys(trials: Trial) -> Trial:
    """``trials`` without theirs, which leave no device as plain arrays, and which nobody reads there."""
    body = trials.state.walker.replace(key=None)
    return trials.replace(scenario=trials.scenario.replace(key=None), state=trials.state.replace(walker=body))
