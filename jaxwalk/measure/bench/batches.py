"""Stages of a tick over batch sizes: all of one batch take turns, with the machine's limits among them."""

from __future__ import annotations

import dataclasses
import os
import statistics
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.sharding import Mesh

from jaxwalk.common import runtime
from jaxwalk.common.parallel import devices
from jaxwalk.config import Config
from jaxwalk.learn.ddpg.replay_buffer import Replay
from jaxwalk.learn.train import device_loop
from jaxwalk.learn.train.device_loop import TrainState
from jaxwalk.measure.bench import costs, limits, stages
from jaxwalk.measure.bench.programs import record, sharded, split, walk_ticks
from jaxwalk.measure.bench.rounds import BARE, BY_XLA, LOOP, TICK, Builder, Program, take_turns
from jaxwalk.measure.bench.stages import OF_WALKER, PLANT, WINDOWS
from jaxwalk.model import pushes
from jaxwalk.task.stepper import Stepper, Task

SHORT = (BARE, BY_XLA, PLANT, TICK, LOOP)  # of a table of batches without all stages
PRODUCT, COPY = "product", "copy"
_CALL = {"cpu": 2**18}  # about so many ticks of a walker a call; more on a GPU
_CALL_GPU = 2**23


def windows_of(walkers: int, config: Config) -> int:
    """Decision windows in a call: as many as training reports on, fewer of large batches."""
    ticks = _CALL.get(jax.default_backend(), _CALL_GPU) / (walkers * config.train.window_ticks)
    return max(1, min(config.train.windows_per_report, round(ticks)))


def of_size(config: Config, walkers: int) -> Config:
    """``config`` for a batch of ``walkers`` and calls of `windows_of` it."""
    train = dataclasses.replace(config.train, walkers=walkers, windows_per_report=windows_of(walkers, config))
    return dataclasses.replace(config, train=train)


@dataclasses.dataclass
class Built:
    """A stage of one batch, compiled, and what is known of it before it runs.

    Attributes:
      program: to be timed. compiled: by XLA.
    """

    program: Program
    compiled: Any


class Herd:
    """The walkers of all batches: those of the smallest one, in mid-step, over again.

    They have walked as training's first ones do, pushed and exploring, until the learner learned.

    Args:
      config: of the smallest batch.
    """

    def __init__(self, config: Config, mesh: Mesh, seed: int, builder: Builder) -> None:
        self.config, self.mesh, self.count = config, mesh, config.train.walkers
        state = device_loop.init(config, mesh, seed)
        self.loop = builder.build(LOOP, device_loop.make(config, mesh), state)
        while float(state.learner.updates) == 0:
            state = self.loop[0](state)
        self.state: TrainState = state
        task = Task.of(config)
        ticks = config.train.windows_per_report * config.train.window_ticks
        self.commands = sharded(partial(record, task, ticks), mesh)(self.unpushed(self.count))

    def of(self, walkers: int) -> TrainState:
        """Training in a batch of so many, nothing of it shared with another."""
        state = jax.tree.map(jnp.copy, self.state.replace(steppers=None, replay=None))
        rings = device_loop.rings(of_size(self.config, walkers))
        return state.replace(
            steppers=split(self._again(self.state.steppers, walkers), self.mesh),
            replay=split(dealt(self.state.replay, rings), self.mesh),
        )

    def unpushed(self, walkers: int) -> Stepper:
        """So many, whom nobody pushes."""
        states = self._again(self.state.steppers, walkers)
        calm = jax.tree.map(lambda none, x: jnp.full_like(x, none), pushes.none(), states.walker.push)
        return split(states.replace(walker=states.walker.replace(push=calm)), self.mesh)

    def followed(self, walkers: int, ticks: int) -> Any:
        """[B, ticks, 6] the commands that the unpushed follow at their nominal step."""
        return split(self._again(self.commands, walkers)[:, :ticks], self.mesh)

    def _again(self, tree: Any, walkers: int) -> Any:
        index = np.resize(np.arange(self.count), walkers)
        return jax.tree.map(lambda x: x[index], tree)


def dealt(memory: Replay, rings: int) -> Replay:
    """``memory`` in another number of rings: each gets the first rows of one of them, some more than once."""
    old = memory.size.shape[0]
    capacity = max(1, memory.capacity * old // rings)
    ring, slot = np.resize(np.arange(old), rings)[:, None], np.arange(capacity) % memory.capacity
    filled = jnp.minimum(memory.size[ring[:, 0]], capacity)
    return Replay(jax.tree.map(lambda x: x[ring, slot], memory.rows), filled % capacity, filled)


def measure(
    config: Config,
    sizes: Sequence[int],
    names: Sequence[str],
    seconds: float,
    seed: int,
    tell: Callable[[str], None],
) -> list[dict[str, Any]]:
    """A row for each batch, as ``jaxwalk bench`` writes it.

    Args:
      sizes: of the batches, ascending, all divisible by the devices that the first is split over.
      names: stages, in order, the bare step first and the training loop last.
      seconds: for each program and batch, or three calls, whichever is more.
      tell: called with what is under way.
    """
    first, builder = of_size(config, sizes[0]), Builder(tell)
    mesh = devices.mesh(device_loop.rings(first))
    herd = Herd(first, mesh, seed, builder)
    ticks = first.train.windows_per_report * first.train.window_ticks
    tell("compiling the limits")
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
        built, why = _build(sized, names, herd, builder)
        if why:
            rows.append({"walkers": walkers, "skipped": why})
            continue
        turns = {name: one.program for name, one in built.items()}
        beside = {name: Program(_limit(one.run), 0.0, False) for name, one in in_c.items()}
        beside |= {name: Program(_limit(run), 0.0, False) for name, (run, _) in machine.items()}
        tell(f"{walkers} walkers, first calls")
        try:
            for program in (*turns.values(), *beside.values()):
                program.run()
        except jax.errors.JaxRuntimeError as error:
            if "RESOURCE_EXHAUSTED" not in str(error):
                raise
            rows.append({"walkers": walkers, "skipped": "the memory is exhausted"})
            continue
        say = partial(_say, tell, f"{walkers} walkers, ")
        take_turns(turns, seconds, say, tuple(beside.values()))
        work = {name: float(one.steps) for name, one in in_c.items()}
        work |= {name: amount for name, (_, amount) in machine.items()}
        rows.append(_row(sized, mesh.size, threads, built, turns | beside, work))
    return rows


def _say(tell: Callable[[str], None], of: str, what: str) -> None:
    tell(of + what)


def _limit(run: Callable[[], Any]) -> Callable[[], tuple[float, float]]:
    def timed() -> tuple[float, float]:
        run()
        return 0.0, 0.0

    return timed


def _build(
    config: Config, names: Sequence[str], herd: Herd, builder: Builder
) -> tuple[dict[str, Built], str | None]:
    """The stages of one batch; and why it must be left out, if it must."""
    built: dict[str, Built] = {}
    walkers, task = config.train.walkers, Task.of(config)
    count = config.train.windows_per_report
    calm, commands = herd.unpushed(walkers), herd.followed(walkers, count * config.train.window_ticks)
    for name in names:
        label = f"{name} of {walkers}"
        if name in OF_WALKER:
            function, follows = stages.of_walker(name, config, task, count)
            args = (calm.walker, commands) if follows else (calm.walker,)
            compiled, cost = builder.build(label, sharded(function, herd.mesh), *args)
            run = _replayed(compiled, args)
        elif name in (TICK, BY_XLA):
            stepped = task if name == TICK else Task.of(dataclasses.replace(config, kernels="off"))
            walk = sharded(partial(walk_ticks, stepped, count), herd.mesh)
            compiled, cost = builder.build(label, walk, calm)
            run = _replayed(compiled, (calm,), lambda result: float(np.sum(result[1])))
        elif name == WINDOWS:
            state = herd.of(walkers)
            function = stages.windowed(config, herd.mesh)
            compiled, cost = builder.build(label, function, state.steppers, state.key)
            run = _walked(compiled, state)
        else:
            state = herd.of(walkers)
            if name == LOOP and walkers == herd.count:
                compiled, cost = herd.loop
            else:
                compiled, cost = builder.build(label, stages.of_training(name, config, herd.mesh), state)
            run = _trained(compiled, state)
        built[name] = Built(Program(run, *cost), compiled)
        if why := _too_large(compiled, herd.mesh.size):
            return built, f"{name}: {why}"
    return built, None


def _replayed(
    compiled: Any, args: tuple[Any, ...], footsteps: Callable[[Any], float] = lambda _: 0.0
) -> Callable[[], tuple[float, float]]:
    return lambda: (footsteps(jax.block_until_ready(compiled(*args))), 0.0)


def _walked(compiled: Any, state: TrainState) -> Callable[[], tuple[float, float]]:
    steppers, key = state.steppers, state.key

    def run() -> tuple[float, float]:
        nonlocal steppers, key
        steppers, key, closed = jax.block_until_ready(compiled(steppers, key))
        return float(closed), 0.0

    return run


def _trained(compiled: Any, state: TrainState) -> Callable[[], tuple[float, float]]:
    def run() -> tuple[float, float]:
        nonlocal state
        before = float(state.learner.updates)
        state = jax.block_until_ready(compiled(state))
        return float(state.counts.footsteps), float(state.learner.updates) - before

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
