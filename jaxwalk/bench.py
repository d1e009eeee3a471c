"""How fast it is: bare ``mjx.step``, the whole tick, the push map and the training loop, side by side.

All four advance the same bodies by the same number of ticks a call, split over all devices. They
take turns, round by round, and medians are reported, so that a machine that slows down or is
shared slows all of them.
"""

from __future__ import annotations

import dataclasses
import resource
import statistics
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.sharding import Mesh, NamedSharding, PartitionSpec
from jaxtyping import Array, Bool, Float
from mujoco import mjx
from rich.console import Console
from rich.table import Table

from jaxwalk import (
    controllers,
    devices,
    files,
    footstep,
    physics,
    pushes,
    results,
    scenarios,
    stepper,
    subjects,
    walker,
    windows,
)
from jaxwalk.config import Config
from jaxwalk.devices import AXIS
from jaxwalk.errors import UserError
from jaxwalk.presets import PRESETS
from jaxwalk.stepper import Stepper, Task
from jaxwalk.train import loop
from jaxwalk.trials import BINS, Profile, Runner
from jaxwalk.walker import Walker

if TYPE_CHECKING:
    from jaxwalk.cli.bench import BenchArgs

BARE, TICK, MAP, LOOP = "mjx_step", "tick", "push_map", "training_loop"
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
    """

    run: Callable[[], tuple[float, float]]
    compile_seconds: float
    cached: bool
    seconds: list[float] = field(default_factory=list)
    footsteps: list[float] = field(default_factory=list)
    updates: list[float] = field(default_factory=list)

    def time(self) -> None:
        begun = time.perf_counter()
        footsteps, updates = self.run()
        self.seconds.append(time.perf_counter() - begun)
        self.footsteps.append(footsteps)
        self.updates.append(updates)

    def rate(self, amounts: list[float]) -> float:
        """Median over the rounds of ``amounts`` a second."""
        return statistics.median(a / s for a, s in zip(amounts, self.seconds, strict=True))


def walk_ticks(task: Task, count: int, state: Stepper) -> tuple[Stepper, Float[Array, ""]]:
    """One walker, ``count`` windows at its nominal step, without a policy; and its footsteps."""

    def window(state: Stepper, _: None) -> tuple[Stepper, Bool[Array, ""]]:
        state = stepper.decide(state, footstep.nominal_action(state.walker.person))
        state = windows.run_ticks(task, state, task.setup.window_ticks)
        return state, state.last.closed

    state, closed = jax.lax.scan(window, state, length=count)
    return state, jnp.sum(closed, dtype=jnp.float32)


def record(task: Task, ticks: int, state: Stepper) -> Float[Array, "T 6"]:
    """The commands that `walk_ticks` gives to the joints, tick by tick."""
    setup = task.setup
    model, bones = walker.model(setup, state.walker.person), walker.skeleton(setup, state.walker.person)

    def tick(state: Stepper, _: None) -> tuple[Stepper, Float[Array, "6"]]:
        body = state.walker
        command = controllers.command(body.person.gait, bones, body.gait, body.estimate)
        state = stepper.decide(state, footstep.nominal_action(body.person))
        return stepper.tick(task, model, state), command

    return jax.lax.scan(tick, state, length=ticks)[1]


def bare_steps(config: Config, task: Task, body: Walker, commands: Float[Array, "T 6"]) -> mjx.Data:
    """One walker, the same ticks as users of MJX write them: ``mjx.step`` on the whole of its data."""
    model = walker.model(task.setup, body.person)
    data = mjx.make_data(physics.compile_mujoco(config.body, config.physics), impl="jax")
    plant = body.plant
    data = data.replace(qpos=plant.qpos, qvel=plant.qvel, qacc_warmstart=plant.warmstart)

    def step(data: mjx.Data, command: Float[Array, "6"]) -> tuple[mjx.Data, None]:
        return mjx.step(model, data.replace(ctrl=command)), None

    return jax.lax.scan(step, data, commands)[0]


class _Hits:
    """Counts the programs that JAX found in its cache."""

    def __init__(self) -> None:
        self.count = 0
        jax.monitoring.register_event_listener(self._hear)

    def _hear(self, event: str, **_: Any) -> None:
        self.count += event == _CACHE_HIT


def measure(config: Config, seconds: float, seed: int, tell: Callable[[str], None]) -> dict[str, Program]:
    """The four programs, each timed for ``seconds`` or `MIN_ROUNDS` calls, whichever is more.

    The bare step and the tick begin every call with the same walkers in mid-step, unpushed, who
    have walked for `SETTLE_CALLS` calls; the bare step then replays the tick's own joint commands,
    so both go through the same motion and the same contacts. The map is that of the shipped policy; its
    walkers, of the configured size, go on walking unpushed, as the loop goes on training.

    Args:
      tell: called with what is under way.
    """
    mesh, task = devices.mesh(config.train.walkers), Task.of(config)
    count = config.train.windows_per_report
    ticks = count * task.setup.window_ticks
    hits = _Hits()

    def build(name: str, function: Any, *args: Any) -> tuple[Any, tuple[float, bool]]:
        tell(f"compiling {name}")
        begun = time.perf_counter()
        lowered, before = function.lower(*args), hits.count
        program = lowered.compile()
        return program, (time.perf_counter() - begun, hits.count > before)

    keys = jax.random.split(jax.random.key(seed), config.train.walkers)
    fresh = _sharded(partial(_spawn, config, task), mesh)(_split(keys, mesh))
    tick, tick_cost = build(TICK, _sharded(partial(walk_ticks, task, count), mesh), fresh)
    tell("walking")
    for _ in range(SETTLE_CALLS):
        fresh = tick(fresh)[0]
    steppers = _split(_standing(fresh), mesh)
    commands = _sharded(partial(record, task, ticks), mesh)(steppers)

    stepped = _sharded(partial(bare_steps, config, task), mesh)
    bare, bare_cost = build(BARE, stepped, steppers.walker, commands)

    mapper = subjects.load(subjects.SHIPPED)
    runner = Runner(Task.of(mapper.config), mapper.act, config.train.walkers, mesh)
    nobody = np.zeros(config.train.walkers, np.float32)
    starts = scenarios.batch(mapper.config, nobody, nobody, keys)
    profile = Profile(jnp.zeros(BINS), jnp.float32(0.6))
    trials = runner.begin(mapper.config.gait, starts)
    told = (mapper.params, profile, jnp.int32(count))
    further, map_cost = build(MAP, runner.advance, *told, trials)

    state = loop.init(config, mesh, seed)
    advance, loop_cost = build(LOOP, loop.make(config, mesh), state)
    for _ in range(SETTLE_CALLS):
        trials = further(*told, trials)
    tell("filling the replay")
    while float(state.learner.updates) == 0:
        state = advance(state)

    def run_bare() -> tuple[float, float]:
        jax.block_until_ready(bare(steppers.walker, commands))
        return 0.0, 0.0

    def run_tick() -> tuple[float, float]:
        return float(np.sum(jax.block_until_ready(tick(steppers))[1])), 0.0

    def run_map() -> tuple[float, float]:
        nonlocal trials
        before = float(np.sum(trials.touchdowns))
        trials = jax.block_until_ready(further(*told, trials))
        return float(np.sum(trials.touchdowns)) - before, 0.0

    def run_loop() -> tuple[float, float]:
        nonlocal state
        before = float(state.learner.updates)
        state = jax.block_until_ready(advance(state))
        return float(state.counts.footsteps), float(state.learner.updates) - before

    programs = {
        BARE: Program(run_bare, *bare_cost),
        TICK: Program(run_tick, *tick_cost),
        MAP: Program(run_map, *map_cost),
        LOOP: Program(run_loop, *loop_cost),
    }
    while any(len(p.seconds) < MIN_ROUNDS or sum(p.seconds) < seconds for p in programs.values()):
        tell(f"round {len(programs[LOOP].seconds) + 1}")
        for program in programs.values():
            program.time()
    return programs


def _spawn(config: Config, task: Task, key: Array) -> Stepper:
    state = windows.spawn(config, task, key)
    return state.replace(walker=state.walker.replace(push=pushes.none()))


def _standing(states: Stepper) -> Stepper:
    """Those who fell on the way are replaced by others who did not: a heap is no walk."""
    standing = np.flatnonzero(~np.asarray(states.terminated))
    if not standing.size:
        raise UserError("bench: no walker stands, the configured gait does not walk")
    index = np.resize(standing, states.asked.shape[0])
    return jax.tree.map(lambda x: x[index], states)


def _sharded(function: Callable[..., Any], mesh: Mesh) -> Any:
    rows = PartitionSpec(AXIS)
    mapped = jax.shard_map(
        partial(devices.each, function), mesh=mesh, in_specs=rows, out_specs=rows, check_vma=False
    )
    return jax.jit(mapped)


def _split(tree: Any, mesh: Mesh) -> Any:
    return jax.device_put(tree, NamedSharding(mesh, PartitionSpec(AXIS)))


def bench(args: BenchArgs, tell: Callable[[str], None] = lambda what: None) -> dict[str, Any]:
    """All of it, as the JSON that ``jaxwalk bench`` writes."""
    preset = PRESETS["default"]
    # Updates begin as soon as there is something to learn from; nothing else departs from `jaxwalk train`.
    config = dataclasses.replace(
        preset,
        train=dataclasses.replace(preset.train, walkers=args.walkers),
        ddpg=dataclasses.replace(preset.ddpg, warmup=args.walkers),
    )
    programs = measure(config, args.seconds, args.seed, tell)
    ticks = config.train.windows_per_report * config.train.window_ticks
    result: dict[str, Any] = {"programs": {}}
    for name, program in programs.items():
        steps = [float(args.walkers * ticks)] * len(program.seconds)
        result["programs"][name] = {
            "physics_steps_per_second": program.rate(steps),
            "footsteps_per_second": None if name == BARE else program.rate(program.footsteps),
            "updates_per_second": program.rate(program.updates) if name == LOOP else None,
            "compile_seconds": program.compile_seconds,
            "compile_cached": program.cached,
            "round_seconds": program.seconds,
        }
    rates = {name: row["physics_steps_per_second"] for name, row in result["programs"].items()}
    return result | {
        "ratios": {f"{name}/{BARE}": rates[name] / rates[BARE] for name in (TICK, MAP, LOOP)},
        "walkers": args.walkers,
        "ticks_per_call": ticks,
        "memory": _memory(),
        **results.stamp("bench", args, None, config),
    }


def _memory() -> dict[str, float | None]:
    """Peaks since the process began, MB; None where the devices do not tell (CPUs)."""
    unit = 1 if sys.platform == "darwin" else 1024  # bytes there, KiB elsewhere
    stats = [device.memory_stats() for device in jax.local_devices()]
    known = [s["peak_bytes_in_use"] for s in stats if s and "peak_bytes_in_use" in s]
    return {
        "peak_rss_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6,
        "peak_device_mb": sum(known) / 1e6 if known else None,
    }


def main(args: BenchArgs) -> None:
    """The command."""
    console = Console()
    with console.status("starting") as status:
        result = bench(args, status.update)
    if args.json is not None:
        files.write_json(args.json, result)
    _print(console, result)


def _print(console: Console, result: dict[str, Any]) -> None:
    hardware = ", ".join(result["hardware"]["devices"])
    table = Table(title=f"{result['walkers']} walkers, {hardware}", caption="* from the compilation cache")
    table.add_column("program", no_wrap=True)
    for heading in ("ticks/s", "of bare", "footsteps/s", "updates/s", "compile, s"):
        table.add_column(heading, justify="right")
    for name, row in result["programs"].items():
        ratio = result["ratios"].get(f"{name}/{BARE}", 1.0)
        rates = [row[f"{what}_per_second"] for what in ("footsteps", "updates")]
        told = ["-" if rate is None else f"{rate:,.0f}" for rate in rates]
        compiled = f"{row['compile_seconds']:.1f}{'*' if row['compile_cached'] else ' '}"
        table.add_row(name, f"{row['physics_steps_per_second']:,.0f}", f"{ratio:.2f}", *told, compiled)
    console.print(table)
    console.print(f"peak memory {result['memory']['peak_rss_mb']:,.0f} MB", highlight=False)
