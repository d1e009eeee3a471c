"""Measure a policy: does it walk, which pushes does it survive, how soon is it steady again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any

import jax.numpy as jnp
import numpy as np

from jaxwalk.config import BodyConfig, Engine
from jaxwalk.learn.policies.named import Subject
from jaxwalk.measure.protocol import PushTest
from jaxwalk.measure.screen import OnProgress
from jaxwalk.measure.survival import each_phase, threshold, worst_phase
from jaxwalk.model.burdens import Burden
from jaxwalk.task import scenarios, sway
from jaxwalk.task.scenarios import Scenario
from jaxwalk.task.stepper import Task
from jaxwalk.task.trials import BINS, Act, Profile, Runner, Trial, survived

BATCH = 2048  # trials in one program, at most
AFTER_PUSH = 8.0  # s watched after the step in which the last push comes
BEFORE_PUSH = 5.0  # s, enough for the step of the push to be reached


@dataclass(frozen=True)
class Walking:
    """Undisturbed walking; means over walkers and time.

    Attributes:
      survival: share of walkers that never fell.
      speed_mean, speed_std: m/s; the spread is between walkers.
      step_length_mean, step_duration_mean: m, s.
      torso_pitch_mean, torso_pitch_amplitude: rad; the amplitude is half of peak to peak in a step.
    """

    survival: float
    speed_mean: float
    speed_std: float
    step_length_mean: float
    step_duration_mean: float
    torso_pitch_mean: float
    torso_pitch_amplitude: float


@dataclass(frozen=True)
class Pushes:
    """Pushed walking.

    Attributes:
      impulses: [I] N s. phases: [P] share of the step at which the push begins.
      survival: [I][P] share that met its push and walks on at the end, about `AFTER_PUSH` seconds later
        (`trials.walks_on`).
      recovery_seconds: [I][P] mean time until steady, over those that were steady again; None
        where none was.
      steady: [I][P] share that was steady again.
      impulse_delivered: [I] mean impulse that the walkers really received, N s.
    """

    impulses: list[float]
    phases: list[float]
    survival: list[list[float]]
    recovery_seconds: list[list[float | None]]
    steady: list[list[float]]
    impulse_delivered: list[float]


class Programs:
    """The compiled programs of evaluations of one size, so that policies of one kind share theirs."""

    def __init__(self, test: PushTest) -> None:
        self._engine: Engine = test.engine
        self._batch = min(BATCH, max(test.walkers, len(test.impulses) * test.phases * (test.replicas or 1)))
        self._runners: dict[tuple[Act, Task], Runner] = {}

    def of(self, subject: Subject) -> Runner:
        """The one that runs ``subject``."""
        task = Task.of(subject.config, self._engine).endless()
        # Other sizes and noises need no other program: each scenario brings its own.
        body = BodyConfig(table=task.setup.body.table, model=task.setup.body.model)
        sensors = replace(task.setup.sensors, noise=1.0)
        task = replace(task, setup=replace(task.setup, body=body, sensors=sensors))
        key = subject.act, task
        if key not in self._runners:
            self._runners[key] = Runner(task, subject.act, self._batch)
        return self._runners[key]


def evaluate(
    subject: Subject,
    test: PushTest | None = None,
    progress: OnProgress = lambda what, share: None,
    programs: Programs | None = None,
    burden: Burden | None = None,
) -> dict[str, Any]:
    """Walking, pushes and thresholds, as ``jaxwalk evaluate`` writes them.

    Args:
      test: what the policy is put through; default: a `PushTest` as it stands.
      progress: called with what is under way and the share of it that is done.
      programs: made for the same ``test``; default: one of its own.
      burden: what all walkers bear without being told; default: what ``test`` says.
    """
    test = (test or PushTest()).sized(subject.config)
    burden = test.burden(subject.config) if burden is None else burden
    runner = (programs or Programs(test)).of(subject)

    def follow(what: str, batch: Scenario, profile: Profile, seconds: float) -> Trial:
        numbers = subject.config.gait
        return runner.run(subject.params, numbers, profile, batch, seconds, partial(progress, what))

    none = np.zeros(test.walkers, np.float32)
    calm = scenarios.batch(
        subject.config, none, none, scenarios.keys(test.seed, scenarios.CALM, test.walkers), burden=burden
    )
    walked = follow("walking", calm, Profile.blank(), test.seconds)
    result: dict[str, Any] = {"walking": asdict(_walking(walked))}
    trials = [walked]
    if test.impulses:
        tried, pushed = _push_test(subject, test, profile_of(walked), follow, burden)
        trials.append(tried)
        shares = [float(np.mean(row)) for row in pushed.survival]
        each = each_phase(pushed.impulses, pushed.survival)
        result |= {
            "pushes": asdict(pushed),
            "threshold": threshold(pushed.impulses, shares),
            "threshold_worst_phase": worst_phase(each),
        }
    if walked.tally.sway is not None:
        result["walls"] = {
            what: asdict(sway.report(trial.tally.sway, trial.tally.seconds, subject.config.body.height))
            for what, trial in zip(("walking", "pushes"), trials, strict=False)
            if trial.tally.sway is not None
        }
    return result


def _walking(trials: Trial) -> Walking:
    tally = trials.tally
    speeds = tally.distance / np.maximum(tally.seconds, 1e-6)
    steps, seconds = max(tally.steps.sum(), 1.0), max(tally.seconds.sum(), 1e-6)
    return Walking(
        survival=float(np.mean(~trials.state.terminated)),
        speed_mean=float(tally.distance.sum() / seconds),
        speed_std=float(np.std(speeds[tally.seconds > 0])) if (tally.seconds > 0).any() else 0.0,
        step_length_mean=float(tally.step_length.sum() / steps),
        step_duration_mean=float(tally.step_seconds.sum() / steps),
        torso_pitch_mean=float(tally.pitch.sum() / seconds),
        torso_pitch_amplitude=float(tally.pitch_swing.sum() / steps),
    )


def profile_of(trials: Trial) -> Profile:
    """Mean speed over the step, and mean step duration, of walkers that nobody pushed."""
    tally = trials.tally
    count = tally.speed_count.sum(0)
    seen = np.flatnonzero(count)
    speed = tally.speed_sum.sum(0) / np.maximum(count, 1.0)
    if len(seen):  # a step that lasts longer than any unpushed one is held against their end
        speed = np.where(np.arange(BINS) > seen[-1], speed[seen[-1]], speed)
    seconds = tally.step_seconds.sum() / max(tally.steps.sum(), 1.0)
    return Profile(jnp.asarray(speed, jnp.float32), jnp.float32(seconds if seconds > 0 else 0.6))


def _push_test(
    subject: Subject,
    test: PushTest,
    profile: Profile,
    follow: Callable[..., Trial],
    burden: Burden | None,
) -> tuple[Trial, Pushes]:
    impulses = np.array(sorted(test.impulses), np.float32)
    phases = np.arange(test.phases, dtype=np.float32) / test.phases
    shape = (len(impulses), len(phases), test.cell)
    grid = np.broadcast_to(impulses[:, None, None], shape), np.broadcast_to(phases[None, :, None], shape)
    tried = scenarios.batch(
        subject.config,
        grid[0].ravel(),
        grid[1].ravel(),
        scenarios.keys(test.seed, scenarios.PUSHED, int(np.prod(shape))),
        test.push_height,
        test.push_duration,
        burden=burden,
        again=test.push_again,
    )
    ended = follow("pushes", tried, profile, BEFORE_PUSH + test.push_again + AFTER_PUSH)

    up = survived(ended).reshape(shape)
    recovery = ended.tally.recovery.reshape(shape)
    steady = np.isfinite(recovery) & up

    def mean_recovery(i: int, p: int) -> float | None:
        return float(recovery[i, p][steady[i, p]].mean()) if steady[i, p].any() else None

    return ended, Pushes(
        impulses=[float(x) for x in impulses],
        phases=[float(x) for x in phases],
        survival=up.mean(2).tolist(),
        recovery_seconds=[[mean_recovery(i, p) for p in range(shape[1])] for i in range(shape[0])],
        steady=steady.mean(2).tolist(),
        impulse_delivered=ended.tally.impulse.reshape(shape).mean((1, 2)).tolist(),
    )
