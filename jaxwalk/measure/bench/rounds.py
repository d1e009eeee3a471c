"""The programs take turns, round by round, so that a machine that slows down or is shared slows all of them.

All advance the same bodies by the same number of ticks a call, split over all devices.
"""

from __future__ import annotations

import contextlib
import dataclasses
import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from jaxwalk.common.parallel import devices
from jaxwalk.config import Config
from jaxwalk.learn.policies import named
from jaxwalk.learn.train import checkpoint, device_loop
from jaxwalk.learn.train.checkpoint import Checkpoint, Store
from jaxwalk.measure.bench.programs import bare_steps, record, sharded, split, standing, unpushed, walk_ticks
from jaxwalk.task import scenarios
from jaxwalk.task.stepper import Task
from jaxwalk.task.trials import Profile, Runner

BARE, TICK, MAP, LOOP = "mjx_step", "tick", "push_map", "training_loop"
BY_XLA = "tick_by_xla"  # the tick without native code or kernels
SAVING = "training_loop_saving"  # the loop, while a checkpoint of it is written
MIN_ROUNDS = 3
SETTLE_CALLS = 3  # of the tick, from the start to steady walking
_CACHE_HIT = "/jax/compilation_cache/cache_hits"


@dataclass
class Program:
    """A compiled program and what was measured of it.

    Attributes:
      run: one call, from nothing, finished when it returns; gives footsteps and updates made.
      compile_seconds: tracing included. cached: the compiled program came from JAX's cache.
      seconds, footsteps, updates: of each round.
      processor: of each round, s of all of this process's threads: what others take does not count.
    """

    run: Callable[[], tuple[float, float]]
    compile_seconds: float
    cached: bool
    seconds: list[float] = field(default_factory=list)
    footsteps: list[float] = field(default_factory=list)
    updates: list[float] = field(default_factory=list)
    processor: list[float] = field(default_factory=list)

    def time(self) -> None:
        """Make one call, and note how long it took and what it made."""
        begun, spent = time.perf_counter(), time.process_time()
        footsteps, updates = self.run()
        self.seconds.append(time.perf_counter() - begun)
        self.processor.append(time.process_time() - spent)
        self.footsteps.append(footsteps)
        self.updates.append(updates)

    def rate(self, amounts: list[float]) -> float:
        """Median over the rounds of ``amounts`` a second."""
        return statistics.median(a / s for a, s in zip(amounts, self.seconds, strict=True))


class Builder:
    """Compiles programs, and tells how long that took and which of them JAX found in its cache.

    Args:
      tell: called with what is under way.
    """

    def __init__(self, tell: Callable[[str], None]) -> None:
        self.hits = 0
        self._tell = tell
        jax.monitoring.register_event_listener(self._hear)

    def _hear(self, event: str, **_: Any) -> None:
        self.hits += event == _CACHE_HIT

    def build(self, name: str, function: Any, *args: Any) -> tuple[Any, tuple[float, bool]]:
        """``function``, jitted, compiled for ``args``; and what `Program` keeps of that."""
        self._tell(f"compiling {name}")
        begun = time.perf_counter()
        lowered, before = function.lower(*args), self.hits
        program = lowered.compile()
        return program, (time.perf_counter() - begun, self.hits > before)


def take_turns(
    programs: dict[str, Program],
    seconds: float,
    tell: Callable[[str], None],
    beside: Sequence[Program] = (),
) -> None:
    """Round by round, until each was timed for ``seconds`` or `MIN_ROUNDS` calls, whichever is more.

    Args:
      beside: have their turns in every round, too, and do not tell when it is enough.
    """
    while any(len(p.seconds) < MIN_ROUNDS or sum(p.seconds) < seconds for p in programs.values()):
        tell(f"round {1 + min(len(p.seconds) for p in programs.values())}")
        for program in (*programs.values(), *beside):
            program.time()


def measure(
    config: Config, seconds: float, seed: int, folder: Path, tell: Callable[[str], None]
) -> dict[str, Program]:
    """The programs, each timed for ``seconds`` or `MIN_ROUNDS` calls, whichever is more.

    The bare step and the tick begin every call with the same walkers in mid-step, unpushed, who
    have walked for `SETTLE_CALLS` calls; the bare step then replays the tick's own joint commands,
    so both go through the same motion and the same contacts. The map is that of the shipped policy; its
    walkers, of the configured size, go on walking unpushed, as the loop goes on training.

    Args:
      folder: for checkpoints.
      tell: called with what is under way.
    """
    mesh, task = devices.mesh(device_loop.rings(config)), Task.of(config)
    count = config.train.windows_per_report
    ticks = count * task.setup.window_ticks
    builder = Builder(tell)
    build = builder.build

    keys = jax.random.split(jax.random.key(seed), config.train.walkers)
    fresh = sharded(partial(unpushed, config, task), mesh)(split(keys, mesh))
    tick, tick_cost = build(TICK, sharded(partial(walk_ticks, task, count), mesh), fresh)
    plain = Task.of(dataclasses.replace(config, kernels="off"))
    by_xla, xla_cost = build(BY_XLA, sharded(partial(walk_ticks, plain, count), mesh), fresh)
    tell("walking")
    for _ in range(SETTLE_CALLS):
        fresh = tick(fresh)[0]
    steppers = split(standing(fresh), mesh)
    commands = sharded(partial(record, task, ticks), mesh)(steppers)

    stepped = sharded(partial(bare_steps, config, task), mesh)
    bare, bare_cost = build(BARE, stepped, steppers.walker, commands)

    mapper = named.load(named.SHIPPED)
    runner = Runner(Task.of(mapper.config), mapper.act, config.train.walkers, mesh, devices.alike)
    nobody = np.zeros(config.train.walkers, np.float32)
    starts = scenarios.batch(mapper.config, nobody, nobody, keys)
    profile = Profile.blank()
    trials = runner.begin(mapper.config.gait, starts)
    told = (mapper.params, profile, jnp.int32(count))
    tell(f"compiling {MAP}")  # and its first call, short beside that: a program for each device
    begun, before = time.perf_counter(), builder.hits
    trials = jax.block_until_ready(runner.advance(*told, trials))
    map_cost = time.perf_counter() - begun, builder.hits > before

    state = device_loop.init(config, mesh, seed)
    advance, loop_cost = build(LOOP, device_loop.make(config, mesh), state)
    for _ in range(SETTLE_CALLS):
        trials = runner.advance(*told, trials)
    tell("filling the replay")
    while float(state.learner.updates) == 0:
        state = advance(state)

    def run_bare() -> tuple[float, float]:
        jax.block_until_ready(bare(steppers.walker, commands))
        return 0.0, 0.0

    def run_tick() -> tuple[float, float]:
        return float(np.sum(jax.block_until_ready(tick(steppers))[1])), 0.0

    def run_by_xla() -> tuple[float, float]:
        return float(np.sum(jax.block_until_ready(by_xla(steppers))[1])), 0.0

    def run_map() -> tuple[float, float]:
        nonlocal trials
        before = float(np.sum(trials.touchdowns))
        trials = jax.block_until_ready(runner.advance(*told, trials))
        return float(np.sum(trials.touchdowns)) - before, 0.0

    def run_loop() -> tuple[float, float]:
        nonlocal state
        before = float(state.learner.updates)
        state = jax.block_until_ready(advance(state))
        return float(state.counts.footsteps), float(state.learner.updates) - before

    good = Checkpoint(checkpoint.pack(state), {})

    def run_saving() -> tuple[float, float]:
        now = Checkpoint(checkpoint.pack(state), {})
        store.save(checkpoint.of_run(now, good))
        made = run_loop()
        store.wait()
        return made

    programs = {
        BARE: Program(run_bare, *bare_cost),
        BY_XLA: Program(run_by_xla, *xla_cost),
        TICK: Program(run_tick, *tick_cost),
        MAP: Program(run_map, *map_cost),
        LOOP: Program(run_loop, *loop_cost),
        SAVING: Program(run_saving, *loop_cost),
    }
    with contextlib.closing(Store(folder, "bench")) as store:
        take_turns(programs, seconds, tell)
    return programs
