"""Speed against error of the physics' settings: where the chosen defaults come from.

Walkers are taken out of real walking at many points of the step, and the commands that
followed are replayed, open loop, by MJX with each setting and by C MuJoCo, in doubles and
with 100 iterations: once with the same time step (what MJX and the solver lose), once with
0.25 ms (what the time step loses as well). Errors are root mean squares over walkers.

    python scripts/physics_table.py --json physics.json
"""

from __future__ import annotations

import dataclasses
import itertools
import json
import time
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
import tyro
from rich.console import Console
from rich.table import Table

from jaxwalk.common import runtime
from jaxwalk.config import BodyConfig, BodyModel, Config, PhysicsConfig
from jaxwalk.control import walker
from jaxwalk.control.person import Person, model_of
from jaxwalk.model import c_mujoco, physics
from jaxwalk.model.engine import Setup
from jaxwalk.model.similarity import Similarity

FINE = 0.00025  # s
LOOKS = (0.1, 0.5)  # s after the start of the replay
BEGIN, SPREAD = 1.0, 0.6  # s of walking before the first walker is taken, and until the last


@dataclass(frozen=True)
class Args:
    """Options. Every combination of the settings is measured."""

    timesteps: tuple[float, ...] = (0.001, 0.002, 0.004)
    """Time steps, s."""
    iterations: tuple[int, ...] = (1, 2, 3, 4, 8)
    """Newton iterations."""
    contact_timeconsts: tuple[float, ...] = (PhysicsConfig.contact_timeconst,)
    """Contact time constants, s; those shorter than two ticks are skipped."""
    model: BodyModel = "planar"
    """Of the body: planar, or walls."""
    walkers: int = 128
    """Walkers in the batch."""
    json: Path | None = None
    """File for the table, replaced if there."""


@dataclass(frozen=True)
class Replay:
    """[B, D] starts, and the [B, T, 6] commands of T ticks of ``timestep`` s that followed."""

    start: physics.Plant
    commands: np.ndarray
    timestep: float

    def held(self, timestep: float) -> np.ndarray:
        """[B, T', 6] the commands for ticks of ``timestep`` s, each one held until the next."""
        ticks = np.arange(round(LOOKS[-1] / timestep))
        return self.commands[:, np.floor(ticks * timestep / self.timestep + 1e-6).astype(int)]


def record(config: Config, count: int) -> Replay:
    """Walk, and take walkers out evenly over a step's time."""
    setup, dt = Setup.of(config), config.physics.timestep

    def walk(key):
        person = Person.of(config.gait, jnp.float32(config.body.height), jnp.float32(config.body.mass))
        model = model_of(setup, person)

        def tick(state, _):
            command = walker.command(setup, state)
            after, event = walker.tick(setup, model, state)
            return after, (state.plant, command, event.fell)

        state = walker.start(setup, person, key, jnp.float32(config.sensors.noise))
        return jax.lax.scan(tick, state, length=round((BEGIN + SPREAD + LOOKS[-1]) / dt))[1]

    keys = jax.random.split(jax.random.key(0), count)
    plants, commands, fell = jax.device_get(jax.jit(jax.vmap(walk))(keys))
    assert not fell.any(), "the default gait fell"
    rows = np.arange(count)
    at = np.round((BEGIN + SPREAD * rows / count) / dt).astype(int)
    start = jax.tree.map(lambda x: x[rows, at], plants)
    return Replay(start, np.stack([commands[i, k : k + round(LOOKS[-1] / dt)] for i, k in enumerate(at)]), dt)


def by_mjx(config: Config, settings: PhysicsConfig, replay: Replay) -> tuple[np.ndarray, float]:
    """[B, T, 3] hip x and z (m) and pitch (rad), and steps a second."""
    model = physics.model_of(config.body, settings, Similarity.of(config.body.height, config.body.mass))

    def one(plant, commands):
        def tick(plant, command):
            plant, _ = physics.step(config.body, settings, model, plant, command, jnp.zeros((7, 2)))
            return plant, plant.qpos[:3]

        return jax.lax.scan(tick, plant, commands)[1]

    commands = jnp.asarray(replay.held(settings.timestep))
    program = jax.jit(jax.vmap(one)).lower(replay.start, commands).compile()
    path = jax.block_until_ready(program(replay.start, commands))
    seconds = []
    for _ in range(3):
        began = time.perf_counter()
        jax.block_until_ready(program(replay.start, commands))
        seconds.append(time.perf_counter() - began)
    return np.asarray(path), commands.shape[0] * commands.shape[1] / min(seconds)


def by_c(config: Config, settings: PhysicsConfig, replay: Replay) -> np.ndarray:
    """[B, T, 3] likewise, by C MuJoCo, solved to convergence."""
    model = physics.compile_mujoco(config.body, c_mujoco.converged(settings))
    data, commands, paths = mujoco.MjData(model), replay.held(settings.timestep), []
    for qpos, qvel, told in zip(replay.start.qpos, replay.start.qvel, commands, strict=True):
        mujoco.mj_resetData(model, data)
        data.qpos, data.qvel, path = qpos, qvel, []
        for command in told:
            data.ctrl[:6] = command
            mujoco.mj_step(model, data)
            path.append(data.qpos[:3].copy())
        paths.append(path)
    return np.array(paths)


def errors(path: np.ndarray, truth: np.ndarray, timestep: float, truth_step: float) -> list[float]:
    """For each look: RMS of the hip's position (m) and of the pitch (rad)."""
    found = []
    for look in LOOKS:
        off = path[:, round(look / timestep) - 1] - truth[:, round(look / truth_step) - 1]
        found += [float(np.sqrt((off[:, :2] ** 2).sum(1).mean())), float(np.sqrt((off[:, 2] ** 2).mean()))]
    return found


def main(args: Args) -> None:
    runtime.setup()
    config = Config(body=BodyConfig(model=args.model))
    replay = record(config, args.walkers)

    def changed(**settings: Any) -> PhysicsConfig:
        return dataclasses.replace(config.physics, **settings)

    @lru_cache
    def fine(timeconst: float) -> np.ndarray:
        return by_c(config, changed(timestep=FINE, contact_timeconst=timeconst), replay)

    names = ("timestep", "iterations", "contact_timeconst")
    grid = itertools.product(args.timesteps, args.iterations, args.contact_timeconsts)
    rows = []
    for values in grid:
        settings = changed(**dict(zip(names, values, strict=True)))
        if settings.contact_timeconst < 2 * settings.timestep:
            continue
        path, speed = by_mjx(config, settings, replay)
        same = errors(path, by_c(config, settings, replay), settings.timestep, settings.timestep)
        whole = errors(path, fine(settings.contact_timeconst), settings.timestep, FINE)
        keys = [f"{what}_{look}s" for look in LOOKS for what in ("hip_m", "pitch_rad")]
        rows.append(
            dict(zip(names, values, strict=True))
            | {"steps_per_second": speed, "simulated_per_second": speed * settings.timestep}
            | {"same_step": dict(zip(keys, same, strict=True))}
            | {"fine_step": dict(zip(keys, whole, strict=True))}
        )

    table = Table(title=f"{args.walkers} walkers; errors: hip mm / pitch mrad", title_justify="left")
    looks = [f"{look:g} s vs C, {which}" for which in ("same step", "0.25 ms") for look in LOOKS]
    for column in ("step ms", "iter", "contact ms", "speed", *looks):
        table.add_column(column, justify="right")
    fastest = max(row["simulated_per_second"] for row in rows)
    for row in rows:
        cells = [f"{row['timestep'] * 1e3:g}", str(row["iterations"])]
        cells += [f"{row['contact_timeconst'] * 1e3:g}", f"{row['simulated_per_second'] / fastest:.2f}"]
        for which in ("same_step", "fine_step"):
            thousandths = [1e3 * value for value in row[which].values()]
            pairs = zip(thousandths[::2], thousandths[1::2], strict=True)
            cells += [f"{hip:.3g} / {pitch:.3g}" for hip, pitch in pairs]
        table.add_row(*cells)
    Console(width=130).print(table)
    if args.json is not None:
        result = {"rows": rows, "walkers": args.walkers} | runtime.hardware()
        args.json.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main(tyro.cli(Args, description=__doc__))
