"""Find the low-level controllers' numbers, on the training physics: by a grid, or by CMA-ES.

    python scripts/tune.py sweep --set swing_rate_max=7.35,8.5,10 length_nominal=0.62,0.68
    python scripts/tune.py search --generations 20 --out tuned.json

``sweep`` tries every combination with the step that is never adapted, and shows which pushes are
survived at which phase of the step. ``search`` pairs each candidate with a linear footstep rule
(length and duration from the observation), which is thrown away afterwards: controllers are wanted
that a policy can use, not ones that walk best when the step is never adapted.
"""

from __future__ import annotations

import dataclasses
import itertools
import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import cmaes
import jax
import jax.numpy as jnp
import numpy as np
import tyro

from jaxwalk.common import runtime
from jaxwalk.config import Config, GaitConfig
from jaxwalk.control.person import Person
from jaxwalk.task import footstep, scenarios
from jaxwalk.task.stepper import Task
from jaxwalk.task.trials import BINS, Profile, Runner

# What `search` moves, and how far; CMA-ES works on the unit cube.
RANGES = {
    "length_nominal": (0.46, 0.9),
    "duration_nominal": (0.06, 0.19),
    "pitch_nominal": (0.03, 0.15),
    "swing_rate_max": (6.0, 12.0),
    "swing_pitch_gain": (0.0, 1.2),
    "swing_knee": (0.9, 1.6),
    "swing_knee_share": (0.5, 0.92),
    "swing_ankle": (0.0, 0.4),
    "terminal_hip_gain": (1.0, 24.0),
    "toe_off_duration": (0.026, 0.06),
    "toe_off_gain": (150.0, 500.0),
    "toe_off_speed": (1.1, 1.6),
    "touchdown_share": (0.4, 0.9),
}
# The rule: change of action for one unit above its usual value of each observable, at most.
USUAL = np.array([1.15, 0.09, 0.2, 0.5, 0.0], np.float32)
RULE = np.array([[2.0, 2.0, 1.0, 1.0, 0.3], [2.0, 2.0, 1.0, 1.0, 0.3]], np.float32)
CALM = 8
SECONDS = 8.0
PROFILE_SECONDS = 0.5  # a step, for the phase at which a push begins


@dataclass(frozen=True)
class Common:
    """What both ways need."""

    impulses: tuple[float, ...] = (50.0, 60.0, 70.0, -40.0, -50.0)
    """Pushes, N s."""
    phases: int = 16
    """Points of the step at which they begin."""
    seed: int = 0
    """Of the starts, the noise and CMA-ES."""


@dataclass(frozen=True)
class Sweep(Common):
    """Try every combination of the values given, with the step that is never adapted."""

    set: Annotated[tuple[str, ...], tyro.conf.arg(metavar="NAME=A,B,...")] = ()
    """Fields of the gait's configuration and the values to try."""


@dataclass(frozen=True)
class Search(Common):
    """CMA-ES over the gait's numbers and a linear footstep rule."""

    out: Path = Path("tuned.json")
    """Where the best numbers go (JSON)."""
    generations: int = 20
    """Generations."""
    population: int = 16
    """Candidates a generation."""
    sigma: float = 0.15
    """First step size, share of each range."""


@dataclass
class Bench:
    """Runs candidates, one after the other, through the same program and the same pushes."""

    args: Common
    config: Config = field(default_factory=Config)

    def __post_init__(self) -> None:
        cases = [(i, p / self.args.phases) for i in self.args.impulses for p in range(self.args.phases)]
        self.impulse, phase = np.array(cases + [(0.0, 0.0)] * CALM, np.float32).T
        count = len(self.impulse)
        config = self.config
        self.scenarios = scenarios.batch(
            config, self.impulse, phase, scenarios.keys(self.args.seed, scenarios.TUNE, count)
        )
        self.profile = Profile(jnp.zeros(BINS), jnp.float32(PROFILE_SECONDS))
        self.runner = Runner(Task.of(config), lambda p, o: p["step"] + p["rule"] @ (o - USUAL), count)

    def __call__(self, numbers: GaitConfig, rule: np.ndarray):
        """(survived [N], speed of the calm m/s) of one candidate."""
        body = self.config.body
        person = Person.of(numbers, jnp.float32(body.height), jnp.float32(body.mass))
        params = {"step": footstep.nominal_action(person), "rule": jnp.asarray(rule, jnp.float32)}
        strong = jax.tree.map(lambda x: jnp.asarray(x, jnp.float32), numbers)
        ended = self.runner.run(params, strong, self.profile, self.scenarios, SECONDS)
        calm = self.impulse == 0
        speed = ended.tally.distance[calm].sum() / max(ended.tally.seconds[calm].sum(), 1e-3)
        return ~np.asarray(ended.state.terminated), float(speed)

    def show(self, alive: np.ndarray, speed: float) -> str:
        rows = [
            f"{i:+.0f} " + "".join(".x"[not up] for up in alive[self.impulse == i])
            for i in self.args.impulses
        ]
        return f"{speed:.3f} m/s, {alive[self.impulse == 0].mean():.0%} calm  " + "  ".join(rows)


def sweep(args: tyro.conf.OmitArgPrefixes[Sweep]) -> None:
    bench = Bench(args)
    asked = [one.partition("=") for one in args.set]
    grid = [[(name, float(value)) for value in values.split(",")] for name, _, values in asked]
    for combination in itertools.product(*grid):
        numbers = dataclasses.replace(bench.config.gait, **dict(combination))
        name = " ".join(f"{k}={v:g}" for k, v in combination)
        print(f"{name:40s} {bench.show(*bench(numbers, np.zeros_like(RULE)))}", flush=True)


def unpack(unit: np.ndarray) -> tuple[dict[str, float], np.ndarray]:
    """Gait numbers and the [2, O] rule of one point of the unit cube."""
    values = {
        name: float(low + (high - low) * x)
        for x, (name, (low, high)) in zip(unit, RANGES.items(), strict=False)
    }
    return values, (2 * unit[len(RANGES) :].reshape(RULE.shape) - 1) * RULE


def search(args: tyro.conf.OmitArgPrefixes[Search]) -> None:
    bench = Bench(args)
    start = [(getattr(bench.config.gait, n) - low) / (high - low) for n, (low, high) in RANGES.items()]
    mean = np.array(start + [0.5] * RULE.size)
    bounds = np.tile([0.0, 1.0], (len(mean), 1))
    cma = cmaes.CMA(mean, args.sigma, bounds=bounds, population_size=args.population, seed=args.seed)
    best = np.inf
    for generation in range(args.generations):
        told = []
        for _ in range(args.population):
            unit = cma.ask()
            values, rule = unpack(unit)
            alive, speed = bench(dataclasses.replace(bench.config.gait, **values), rule)
            calm = bench.impulse == 0
            off = max(0.0, abs(speed - bench.config.gait.speed_desired) - 0.03)
            cost = float((~alive[~calm]).mean() + 2 * (~alive[calm]).mean() + 3 * off)
            told.append((unit, cost))
            if cost < best:
                best = cost
                args.out.write_text(
                    json.dumps({"cost": cost, "gait": values, "rule": rule.tolist()}, indent=1)
                )
                print(f"{generation:3d} {cost:.3f} {bench.show(alive, speed)}", flush=True)
        cma.tell(told)


if __name__ == "__main__":
    runtime.setup()
    tyro.extras.subcommand_cli_from_dict({"sweep": sweep, "search": search}, description=__doc__)
