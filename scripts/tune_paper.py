"""Find by CMA-ES the numbers that the paper leaves out, for the preset ``paper`` with Gazebo's drives.

    python scripts/tune_paper.py --minutes 10 --out paper.json

Each candidate walks with the nominal step, never adapted, in C MuJoCo; some of its walkers are pushed.
What the paper prints (phi0, the ankle's damping, eqs 14-22) is not moved.
"""

from __future__ import annotations

import dataclasses
import json
import time
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import cmaes
import jax
import jax.numpy as jnp
import numpy as np
import tyro

from jaxwalk.common import runtime
from jaxwalk.config import Config
from jaxwalk.config.presets import PRESETS
from jaxwalk.control import walker
from jaxwalk.control.person import Person
from jaxwalk.model import engine, pushes
from jaxwalk.model.engine import Setup

RANGES = {
    "gait.duration_nominal": (0.06, 0.19),
    "gait.stance_rate_max": (1.5, 8.0),
    "gait.swing_rate_max": (5.0, 14.0),
    "gait.swing_pitch_gain": (0.0, 1.2),
    "gait.swing_knee": (0.7, 1.6),
    "gait.swing_knee_share": (0.4, 0.95),
    "gait.swing_ankle": (0.0, 0.6),
    "gait.terminal_hip_gain": (2.0, 24.0),
    "gait.toe_off_duration": (0.02, 0.1),
    "gait.toe_off_speed": (1.0, 1.6),
    "gait.toe_off_ankle": (0.2, 0.7),
    "gait.touchdown_share": (0.4, 0.98),
    "gait.touchdown_ahead": (0.02, 0.4),
    "physics.gazebo.hip.proportional": (100.0, 280.0),
    "physics.gazebo.hip.integral": (0.0, 2000.0),
    "physics.gazebo.hip.derivative": (0.0, 0.1),
    "physics.gazebo.knee.proportional": (20.0, 50.0),
    "physics.gazebo.knee.integral": (0.0, 600.0),
    "physics.gazebo.knee.derivative": (0.0, 0.02),
    "physics.gazebo.knee_position_gain": (8.0, 30.0),
    "physics.gazebo.knee_rate_max": (6.0, 18.0),
    "physics.gazebo.retraction_seconds": (0.02, 0.1),
}
NAMES = tuple(RANGES)
LOW, HIGH = np.array(list(RANGES.values())).T
SETTLE, PUSHED = 1.5, 2.0  # s: when the speed begins to count, and when the push may come


@dataclass(frozen=True)
class Args:
    """What is searched, and for how long."""

    out: Path = Path("paper.json")
    """Where the best numbers go (JSON)."""
    begin: Path | None = None
    """Such a file to begin from; default: the preset."""
    minutes: float = 10.0
    """How long, roughly."""
    seconds: float = 5.0
    """How long each walker walks, s."""
    population: int = 16
    """Candidates a generation."""
    impulses: tuple[float, ...] = (0.0, 0.0, 0.0, 15.0, -20.0)
    """Pushes of each candidate's walkers, N s; 0 is none."""
    sigma: float = 0.15
    """First step size, share of each range."""
    seed: int = 0
    """Of the starts, the noise and CMA-ES."""


def read(config: Any, name: str) -> float:
    """The field of the dotted ``name``."""
    for part in name.split("."):
        config = getattr(config, part)
    return config


def put(config: Any, name: str, value: Any) -> Any:
    """``config`` with ``value`` in the field of the dotted ``name``."""
    head, _, rest = name.partition(".")
    return dataclasses.replace(config, **{head: put(getattr(config, head), rest, value) if rest else value})


def changed(config: Config, values: Any) -> Config:
    """``config`` with ``values`` (numbers or tracers) in the order of `NAMES`."""
    for name, value in zip(NAMES, values, strict=True):
        config = put(config, name, value)
    seconds = config.gait.toe_off_duration  # the paper's is constant
    gait = dataclasses.replace(config.gait, toe_off_duration_min=seconds, toe_off_duration_max=seconds)
    return dataclasses.replace(config, gait=gait)


def life(config: Config, ticks: int, values: jax.Array, impulse: jax.Array, key: jax.Array) -> tuple:
    """(seconds up, distance after `SETTLE`, mean |pitch| likewise) of one walker."""
    setup, dt = Setup.of(config, "mujoco"), config.physics.timestep
    tried = changed(config, values)
    told = dataclasses.replace(setup, physics=tried.physics)  # traced: for the drives alone
    body = config.body
    person = Person.of(tried.gait, jnp.float32(body.height), jnp.float32(body.mass))
    key, when = jax.random.split(key)
    begun = walker.start(setup, person, key, jnp.float32(1))
    last = config.pushes.duration
    push = pushes.of_impulse(
        impulse,
        ((PUSHED + 0.6 * jax.random.uniform(when)) / dt).astype(jnp.int32),
        last,
        dt,
        jnp.zeros(()),
    )

    def tick(carry, index):
        state, up, far, lean = carry
        before = state.plant.qpos[0]
        state, control, loads = walker.drive(told, state)
        plant, readings = engine.move(setup, None, person.ratio, None, state.plant, control, loads)
        state, event = walker.advance(setup, state, plant, readings, walker.noise(state, 1)[0])
        up = up & ~event.fell
        counts = up & (index * dt >= SETTLE)
        far = far + jnp.where(counts, state.plant.qpos[0] - before, 0.0)
        lean = lean + jnp.where(counts, jnp.abs(state.plant.qpos[2]), 0.0) * dt
        # C computes nothing for what is not finite.
        gone = state.plant.replace(qpos=jnp.where(up, state.plant.qpos, jnp.nan))
        return (state.replace(plant=gone), up, far, lean), up

    start = (begun.replace(push=push), jnp.bool_(True), jnp.zeros(()), jnp.zeros(()))
    (_, _, far, lean), up = jax.lax.scan(tick, start, jnp.arange(ticks))
    return jnp.sum(up) * dt, far, lean


def main(args: Args) -> None:
    config = PRESETS["paper"]
    ticks = round(args.seconds / config.physics.timestep)
    each = jax.vmap(partial(life, config, ticks), (None, 0, 0))
    run = jax.jit(jax.vmap(each, (0, None, None)))
    impulses = np.array(args.impulses, np.float32)
    mean = np.array([read(config, name) for name in NAMES])
    if args.begin is not None:
        found = json.loads(args.begin.read_text())["mean"]
        mean = np.array([found.get(name, value) for name, value in zip(NAMES, mean, strict=True)])
    unit = np.clip((mean - LOW) / (HIGH - LOW), 0.01, 0.99)
    bounds = np.tile([0.0, 1.0], (len(unit), 1))
    cma = cmaes.CMA(unit, args.sigma, bounds=bounds, population_size=args.population, seed=args.seed)
    best, kept, began, generation = np.inf, [], time.monotonic(), 0
    while time.monotonic() - began < 60 * args.minutes:
        asked = [cma.ask() for _ in range(args.population)]
        values = (LOW + np.array(asked) * (HIGH - LOW)).astype(np.float32)
        keys = jax.random.split(jax.random.key(args.seed + generation), len(impulses))
        up, far, lean = jax.device_get(run(values, impulses, keys))
        counted = np.maximum(up - SETTLE, 1e-3)
        speed = np.where(up > SETTLE + 0.5, far / counted, 0.0)
        off = np.abs(speed - config.gait.speed_desired)
        cost = (2 * (1 - up / args.seconds) + off + 0.5 * lean / counted).mean(1)
        cma.tell(list(zip(asked, cost, strict=True)))
        first = int(np.argmin(cost))
        mark = ""
        if cost[first] < best:
            best, mark, kept = cost[first], "*", values[first].tolist()
        middle = dict(zip(NAMES, (LOW + cma.mean * (HIGH - LOW)).tolist(), strict=True))
        told = dict(zip(NAMES, kept, strict=True))
        args.out.write_text(json.dumps({"cost": float(best), "values": told, "mean": middle}, indent=1))
        print(
            f"{generation:3d} {time.monotonic() - began:4.0f} s  cost {cost[first]:.3f}{mark} median "
            f"{np.median(cost):.3f}  up {up[first].round(1)} s  {speed[first].round(2)} m/s",
            flush=True,
        )
        generation += 1


if __name__ == "__main__":
    runtime.setup()
    main(tyro.cli(Args, description=__doc__))
