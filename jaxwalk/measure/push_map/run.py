"""The trials of a push map, chunk by chunk; what is done is kept."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from jaxwalk.common.errors import UserError
from jaxwalk.common.parallel import devices
from jaxwalk.config import Engine
from jaxwalk.learn.policies.named import Subject
from jaxwalk.measure.evaluate import evaluation
from jaxwalk.measure.push_map.table import Table
from jaxwalk.model import pushes
from jaxwalk.task import scenarios
from jaxwalk.task.stepper import Task
from jaxwalk.task.trials import Profile, Runner, Trial, survived

CALM = 64  # unpushed walkers, whose speed recovery is held against
CALM_SECONDS = 15.0


def run(
    subject: Subject,
    engine: Engine,
    table: Table,
    chunk: int,
    folder: Path,
    progress: Callable[[float], None],
) -> tuple[Trial, float]:
    """Fill ``table`` in place, saving it after each chunk.

    Args:
      engine: what moves the walkers.
      chunk: trials in one program, at most (rounded up to the devices).
      progress: called with the share of all the work that is done.

    Returns:
      The unpushed walkers' trials, and the ticks a second of the chunks run now (0: none).

    Raises:
      UserError: the policy does not walk, or the table cannot be saved; what was saved before stands.
    """
    grid, config = table.grid, subject.config
    missing = np.flatnonzero(~table.done)
    chunks = max(1, -(-len(missing) // chunk))  # of equal size: filling up the last one is wasted work
    batch = max(1, -(-len(missing) // chunks))
    runner = Runner(Task.of(config, engine), subject.act, batch, spread=devices.alike)
    follow = partial(runner.run, subject.params, config.gait)
    none = np.zeros(CALM, np.float32)
    calm = scenarios.batch(config, none, none, scenarios.keys(grid.seed, scenarios.CALM, CALM))
    walked = follow(Profile.blank(), calm, CALM_SECONDS)
    if not walked.tally.steps.sum():
        raise UserError(f"policy {subject.name} does not walk: all of {CALM} unpushed walkers fell at once")
    profile = evaluation.profile_of(walked)

    columns, keys = grid.columns(), scenarios.keys(grid.seed, scenarios.PUSHED, grid.size)
    places, heights = grid.where()
    seconds = evaluation.BEFORE_PUSH + max(grid.durations) + evaluation.AFTER_PUSH
    ticks = spent = 0.0
    for first in range(0, len(missing), runner.batch):
        rows = missing[first : first + runner.batch]
        tried = scenarios.batch(
            config,
            columns["impulse"][rows],
            columns["phase"][rows],
            keys[rows],
            heights[rows],
            columns["duration"][rows],
            places[rows],
        )
        done = grid.size - len(missing) + first

        def part(share: float, done: int = done, rows: NDArray = rows) -> None:
            progress((done + share * len(rows)) / grid.size)

        begun = time.perf_counter()
        trials = follow(profile, tried, seconds, part)
        spent += time.perf_counter() - begun
        ticks += len(rows) * runner.ticks(seconds)
        table.put(rows, _results(trials, config.physics.timestep))
        table.save(folder)
    return walked, ticks / spent if spent else 0.0


def _results(trials: Trial, timestep: float) -> dict[str, NDArray]:
    tally = trials.tally
    start = np.asarray(trials.state.walker.push.start)
    fell = np.isfinite(tally.fall_seconds) & (start < pushes.NEVER)
    up = survived(trials)
    recovery = np.where(up & np.isfinite(tally.recovery), tally.recovery, np.nan)
    return {
        "survived": up,
        "fall_seconds": np.where(fell, tally.fall_seconds - start * timestep, np.nan),
        "recovery_seconds": recovery,
        "impulse_delivered": np.asarray(tally.impulse),
        "longest": np.asarray(tally.longest),
        "shortest": np.asarray(tally.shortest),
    }
