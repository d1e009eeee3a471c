"""The programs of a batch take turns; over batch sizes, with the machine's limits among them.

Of a batch, the bare step and what is one walker's alone begin every call with the same walkers in mid-step,
unpushed; the bare step replays the tick's own joint commands, so both go through the same motion and the
same contacts. Training goes on training, the push map's walkers go on walking.
"""

from __future__ import annotations

import contextlib
import dataclasses
import os
import statistics
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from jaxwalk.common import runtime
from jaxwalk.common.parallel import devices
from jaxwalk.config import Config
from jaxwalk.learn.policies import named
from jaxwalk.learn.train import checkpoint, device_loop
from jaxwalk.learn.train.checkpoint import Checkpoint, Store
from jaxwalk.learn.train.device_loop import TrainState
from jaxwalk.measure.bench import costs, limits, stages
from jaxwalk.measure.bench.herd import Herd, of_size
from jaxwalk.measure.bench.programs import sharded, walk_ticks
from jaxwalk.measure.bench.rounds import (
    BARE,
    BY_XLA,
    LOOP,
    MAP,
    SAVING,
    TICK,
    Builder,
    Program,
    Run,
    take_turns,
)  # fmt: skip
from jaxwalk.measure.bench.stages import OF_WALKER, PLANT, WINDOWS
from jaxwalk.task import scenarios
from jaxwalk.task.stepper import Task
from jaxwalk.task.trials import Profile, Runner

SHORT = (BARE, BY_XLA, PLANT, TICK, LOOP)  # of a table of batches without all stages
WHOLE = (BARE, BY_XLA, TICK, MAP, LOOP, SAVING)  # of a table of one batch
SETTLE_CALLS = 3  # of the push map, from the start to steady walking
PRODUCT, COPY = "product", "copy"


@dataclasses.dataclass
class Built:
    """A stage of one batch, compiled, and what is known of it before it runs.

    Attributes:
      program: to be timed. compiled: by XLA; None of the push map, which is a program for each device.
    """

    program: Program
    compiled: Any


def whole(
    config: Config, seconds: float, seed: int, folder: Path, report: Callable[[str], None]
) -> dict[str, Program]:
    """The programs of one batch, each timed for ``seconds`` or `rounds.MIN_ROUNDS` calls, whichever is more.

    Args:
      folder: for checkpoints.
      report: called with what is under way.
    """
    builder = Builder(report)
    herd = Herd(config, devices.mesh(device_loop.blocks(config)), seed, builder)
    with contextlib.closing(Store(folder, "bench")) as store:
        programs = {name: _build(name, config, herd, builder, store).program for name in WHOLE}
        take_turns(programs, seconds, report)
    return programs


def measure(
    config: Config,
    sizes: Sequence[int],
    names: Sequence[str],
    seconds: float,
    seed: int,
    report: Callable[[str], None],
) -> list[dict[str, Any]]:
    """A row for each batch, as ``jaxwalk bench`` writes it.

    Args:
      sizes: of the batches, ascending, all divisible by the devices that the first is split over.
      names: stages, in order, the bare step first and the training loop last.
      seconds: for each program and batch, or three calls, whichever is more.
      report: called with what is under way.
    """
    first, builder = of_size(config, sizes[0]), Builder(report)
    mesh = devices.mesh(device_loop.blocks(first))
    herd = Herd(first, mesh, seed, builder)
    ticks = first.train.windows_per_report * first.train.window_ticks
    report("compiling the limits")
    calm, commands = herd.unpushed(sizes[0]), herd.followed(sizes[0], ticks)
    cores = runtime.hardware()["hardware"]["cores"]
    threads = mesh.size if jax.default_backend() == "cpu" else cores
    in_c = {
        name: limits.Rollouts(config, calm.walker, commands, threads, name == limits.C_CONVERGED)
        for name in (limits.C_LIMITED, limits.C_CONVERGED)
    }
    machine = {PRODUCT: limits.product(mesh), COPY: limits.copy(mesh)}
    rows = []
    for walkers in sizes:
        sized = of_size(config, walkers)
        built, why = _build_all(sized, names, herd, builder)
        if why:
            rows.append({"walkers": walkers, "skipped": why})
            continue
        turns = {name: one.program for name, one in built.items()}
        beside = {name: Program(_limit(one.run), 0.0, False) for name, one in in_c.items()}
        beside |= {name: Program(_limit(run), 0.0, False) for name, (run, _) in machine.items()}
        report(f"{walkers} walkers, first calls")
        try:
            for program in (*turns.values(), *beside.values()):
                program.run()
        except jax.errors.JaxRuntimeError as error:
            if "RESOURCE_EXHAUSTED" not in str(error):
                raise
            rows.append({"walkers": walkers, "skipped": "the memory is exhausted"})
            continue
        say = partial(_say, report, f"{walkers} walkers, ")
        take_turns(turns, seconds, say, tuple(beside.values()))
        work = {name: float(one.steps) for name, one in in_c.items()}
        work |= {name: amount for name, (_, amount) in machine.items()}
        rows.append(_row(sized, mesh.size, threads, built, turns | beside, work))
    return rows


def _say(report: Callable[[str], None], of: str, what: str) -> None:
    report(of + what)


def _limit(run: Callable[[], Any]) -> Run:
    def timed() -> tuple[float, float]:
        run()
        return 0.0, 0.0

    return timed


def _build_all(
    config: Config, names: Sequence[str], herd: Herd, builder: Builder
) -> tuple[dict[str, Built], str | None]:
    """The stages of one batch; and why it must be left out, if it must."""
    built: dict[str, Built] = {}
    for name in names:
        built[name] = _build(name, config, herd, builder)
        if why := _too_large(built[name].compiled, herd.mesh.size):
            return built, f"{name}: {why}"
    return built, None


def _build(name: str, config: Config, herd: Herd, builder: Builder, store: Store | None = None) -> Built:
    """One program of one batch.

    Args:
      store: for checkpoints of the loop that saves.
    """
    walkers, task = config.train.walkers, device_loop.task_of(config)
    count = config.train.windows_per_report
    label = f"{name} of {walkers}"
    if name in OF_WALKER:
        function, follows = stages.of_walker(name, config, task, count)
        body = herd.unpushed(walkers).walker
        args = (body, herd.followed(walkers, count * config.train.window_ticks)) if follows else (body,)
        compiled, cost = builder.build(label, sharded(function, herd.mesh), *args)
        run = _replayed(compiled, args)
    elif name in (TICK, BY_XLA):
        stepped = task if name == TICK else device_loop.task_of(dataclasses.replace(config, kernels="off"))
        calm = herd.unpushed(walkers)
        compiled, cost = builder.build(label, sharded(partial(walk_ticks, stepped, count), herd.mesh), calm)
        run = _replayed(compiled, (calm,), lambda result: float(np.sum(result[1])))
    elif name == MAP:
        compiled, run = None, _mapped(walkers, count, herd)
        _, cost = builder.clocked(label, run)  # its first call, short beside that
        for _ in range(SETTLE_CALLS):
            run()
    elif name == WINDOWS:
        state = herd.of(walkers)
        compiled, cost = builder.build(label, stages.windowed(config, herd.mesh), state.steppers, state.key)
        run = _walked(compiled, state)
    else:
        state = herd.of(walkers)
        if name in (LOOP, SAVING) and walkers == herd.count:
            compiled, cost = herd.loop
        else:
            compiled, cost = builder.build(label, stages.of_training(name, config, herd.mesh), state)
        run = _trained(compiled, state, store if name == SAVING else None)
    return Built(Program(run, *cost), compiled)


def _replayed(compiled: Any, args: tuple[Any, ...], footsteps: Callable[[Any], float] = lambda _: 0.0) -> Run:
    return lambda: (footsteps(jax.block_until_ready(compiled(*args))), 0.0)


def _walked(compiled: Any, state: TrainState) -> Run:
    steppers, key = state.steppers, state.key

    def run() -> tuple[float, float]:
        nonlocal steppers, key
        steppers, key, landed = jax.block_until_ready(compiled(steppers, key))
        return float(landed), 0.0

    return run


def _mapped(walkers: int, count: int, herd: Herd) -> Run:
    """``count`` windows a call of the shipped policy's push map, whose walkers nobody pushes."""
    subject = named.load(named.SHIPPED)
    runner = Runner(Task.of(subject.config), subject.act, walkers, herd.mesh, devices.alike)
    nobody = np.zeros(walkers, np.float32)
    keys = scenarios.keys(herd.seed, scenarios.CALM, walkers)
    trials = runner.begin(subject.config.gait, scenarios.batch(subject.config, nobody, nobody, keys))

    def run() -> tuple[float, float]:
        nonlocal trials
        before = float(np.sum(trials.touchdowns))
        told = subject.params, Profile.blank(), jnp.int32(count)
        trials = jax.block_until_ready(runner.advance(*told, trials))
        return float(np.sum(trials.touchdowns)) - before, 0.0

    return run


def _trained(compiled: Any, state: TrainState, store: Store | None = None) -> Run:
    """The loop; with a ``store``, while a checkpoint is written."""
    good = store and Checkpoint(checkpoint.pack(state), {})

    def run() -> tuple[float, float]:
        nonlocal state
        if store and good:
            store.save(checkpoint.of_run(Checkpoint(checkpoint.pack(state), {}), good))
        before = float(state.learner.updates)
        state = jax.block_until_ready(compiled(state))
        made = float(state.counts.footsteps), float(state.learner.updates) - before
        if store:
            store.wait()
        return made

    return run


def memory(compiled: Any) -> dict[str, int] | None:
    """What ``compiled`` needs on one device, bytes, by XLA's own analysis; None where it makes none."""
    told = compiled.memory_analysis()
    if told is None:
        return None
    return {
        name: int(getattr(told, f"{name}_size_in_bytes")) for name in ("argument", "output", "temp", "alias")
    }


def _too_large(compiled: Any, devices: int) -> str | None:
    """Why ``compiled`` cannot run in the memory there is."""
    told = memory(compiled)
    if told is None:
        return None
    # Its arguments are there already.
    needed = told["output"] - told["alias"] + told["temp"]
    stats = jax.local_devices()[0].memory_stats()
    if stats and "bytes_limit" in stats:
        free = stats["bytes_limit"] - stats["bytes_in_use"]
    else:
        free = os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // devices
    if needed <= free:
        return None
    return f"needs {needed / 1e6:,.0f} MB on each device, {free / 1e6:,.0f} MB are free"


def _row(
    config: Config,
    devices: int,
    threads: int,
    built: dict[str, Built],
    turns: dict[str, Program],
    work: dict[str, float],
) -> dict[str, Any]:
    """What was measured of one batch.

    Args:
      devices, threads: of MJX, of C MuJoCo.
      work: of one call of each limit: steps of C; operations and bytes of a device.
    """
    count = config.train.windows_per_report
    walkers, ticks = config.train.walkers, count * config.train.window_ticks
    steps = float(walkers * ticks)
    rate = {
        name: program.rate([work.get(name, steps)] * len(program.seconds)) for name, program in turns.items()
    }
    solver = float(config.physics.iterations)
    programs, before = {}, None
    for name, one in built.items():
        program = one.program
        updates = statistics.median(program.updates) / count
        cost = costs.of(one.compiled, solver, updates)
        calls = rate[name] / steps  # a second
        programs[name] = {
            "physics_steps_per_second": rate[name],
            "of_bare": rate[name] / rate[BARE],
            "of_c_mujoco": rate[name] / rate[limits.C_LIMITED],
            "added_share": _added("seconds", turns[name], before, turns[LOOP]),
            "added_processor_share": _added("processor", turns[name], before, turns[LOOP]),
            "footsteps_per_second": program.rate(program.footsteps) if any(program.footsteps) else None,
            "updates_per_second": program.rate(program.updates) if name == LOOP else None,
            "compile_seconds": program.compile_seconds,
            "compile_cached": program.cached,
            "round_seconds": program.seconds,
            "round_processor_seconds": program.processor,
            "memory_bytes": memory(one.compiled),
            "flops_per_tick": None if cost is None else cost.flops * devices / steps,
            "bytes_per_tick": None if cost is None else cost.bytes * devices / steps,
            "of_peak_flops": None if cost is None else cost.flops * calls / rate[PRODUCT],
            "of_peak_bytes": None if cost is None else cost.bytes * calls / rate[COPY],
        }
        before = None if name in (BARE, BY_XLA) else turns[name]  # these two stand beside the stages
    stats = [device.memory_stats() for device in jax.local_devices()]
    known = [s["peak_bytes_in_use"] for s in stats if s and "peak_bytes_in_use" in s]
    return {
        "walkers": walkers,
        "ticks_per_call": ticks,
        "programs": programs,
        "limits": {
            name: {"physics_steps_per_second": rate[name], "of_bare": rate[name] / rate[BARE]}
            for name in (limits.C_LIMITED, limits.C_CONVERGED)
        }
        | {
            "c_mujoco_threads": threads,
            "flops_per_second_of_a_device": rate[PRODUCT],
            "bytes_per_second_of_a_device": rate[COPY],
        },
        "peak_device_bytes": max(known) if known else None,
    }


def _added(what: str, program: Program, before: Program | None, whole: Program) -> float:
    """Median over the rounds of what it takes beyond the stage before, as a share of what all take.

    Args:
      what: "seconds", or of the "processor".
    """
    mine, all_ = getattr(program, what), getattr(whole, what)
    less = getattr(before, what) if before else [0.0] * len(mine)
    return statistics.median((m - b) / a for m, b, a in zip(mine, less, all_, strict=True))
