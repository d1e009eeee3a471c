"""Find a walk: the numbers of the compliant controllers and of the step that they plan, by CMA-ES.

    python scripts/tune.py --minutes 15 --out tuned.json

A candidate's walkers are walked by the training's own physics, sensors and noise: some unpushed, of whom the
gait laboratory's measures are taken, the others pushed from both sides at all phases of a step; some bear a
pack, walk on a slope, or are asked for another speed. What is asked of them all, and what it costs not to be
given it, stands in ``tune_goals.py``. Starts and noise are of a purpose of their own (`scenarios.TUNE`),
which no command measures with.
"""

from __future__ import annotations

import dataclasses
import json
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cmaes
import jax
import jax.numpy as jnp
import numpy as np
import tyro
from tune_goals import FALL, GOALS, HARD, PUSHES, WEAKER, Circumstance

from jaxwalk.common import files, runtime
from jaxwalk.common.parallel import devices
from jaxwalk.config import GRAVITY, Config
from jaxwalk.config.presets import PRESETS
from jaxwalk.task import backend, exertion, rules, scenarios, stepper, trials
from jaxwalk.task.exertion import Tried
from jaxwalk.task.rules import Replan
from jaxwalk.task.stepper import Task
from jaxwalk.task.trials import BINS, Profile

# What is searched: least, greatest; of the controllers, then of the step that they plan.
LEGS: dict[str, tuple[float, float]] = {
    "hip_damping": (60, 400), "pitch_nominal": (0.03, 0.3), "pitch_offset": (-0.15, 0.1),
    "pitch_capture_gain": (-0.8, 0.8), "hip_rate_max": (2, 12), "hip_speed_min": (-1.5, 1.5),
    "knee_stiffness": (200, 1400), "knee_damping": (5, 80), "knee_loading": (0.05, 0.55),
    "knee_standing": (0.0, 0.5), "knee_seconds": (0.05, 0.5),
    "ankle_stiffness": (50, 800), "ankle_slack": (-0.2, 0.3), "ankle_damping": (0.5, 14),
    "ankle_capture_gain": (-100, 400),
    "push_off_angle": (0.05, 0.5), "push_off_ramp": (0.02, 0.4), "push_off_torque": (20, 220),
    "push_off_gain": (0, 450), "push_off_ankle": (0.05, 0.6), "toe_off_seconds": (0.03, 0.2),
    "swing_stiffness": (50, 700), "swing_damping": (5, 160), "swing_pitch_gain": (0, 2),
    "swing_rate_max": (5, 12),
    "swing_knee": (0.3, 1.4), "swing_knee_stiffness": (1, 80), "swing_knee_damping": (0.5, 18),
    "landing_knee": (0.0, 0.45), "landing_knee_stiffness": (20, 400), "landing_knee_damping": (1, 30),
    "swing_ankle_stiffness": (2, 100), "swing_ankle_damping": (0, 3),
    "length_speed": (-0.2, 0.9), "duration_speed": (-0.7, 0.3), "capture_speed": (-0.3, 0.9),
    "push_off_speed": (-60, 150),
    "landing_seconds": (0.03, 0.35), "swing_sole": (-0.4, 0.4), "swing_ankle_most": (0.0, 0.6),
    "passing_seconds": (0.0, 0.12), "back_ahead": (-0.4, 0.3), "back_force": (40, 300),
    "balance_ankle": (0.02, 0.8), "balance_sole": (0, 0.5),
    "back_toe_off": (0, 1), "back_pitch_gain": (-1, 1.5),
    "toe_off_least": (0, 0.8), "landing_behind": (-0.1, 0.3),
    "back_knee": (0.2, 1.6), "back_knee_stiffness": (1, 400), "back_knee_damping": (0.5, 30),
    "lag_seconds": (1, 10), "lag_speed": (0.1, 1), "lag_most": (0.1, 1.5), "lag_push_off": (0, 300),
    "lag_pitch": (0, 0.6), "lag_capture": (0, 1),
}  # fmt: skip
RULE: dict[str, tuple[float, float]] = {
    "length": (0.5, 0.95), "duration": (0.45, 0.85), "capture": (0.1, 0.8), "length_gain": (-1, 2),
    "pitch_gain": (-1, 3), "pitch_least": (-0.6, 0.1),
    "duration_gain": (0, 1.2), "duration_least": (0.25, 0.45),
    "back_margin": (-0.1, 0.15), "back_reach": (-0.1, 0.4), "back_gain": (0, 3),
    "back_least": (0.06, 0.35), "back_speed": (1, 6), "back_time": (0.08, 0.4),
}  # fmt: skip
BEFORE = {
    "passing_seconds": 0.05,
    "back_ahead": 0.05,
    "back_force": 120.0,
    "back_toe_off": 1.0,
    "toe_off_least": -1.0,
    "landing_behind": 100.0,
    "length_speed": 0.0,
    "duration_speed": 0.0,
    "capture_speed": 0.0,
    "push_off_speed": 0.0,
    "swing_ankle_stiffness": 77.0,
    "swing_ankle_damping": 1.5,
    "balance_ankle": 100.0,
    "balance_sole": 100.0,
    "lag_seconds": 1.0,
    "lag_speed": 0.5,
    "lag_most": 0.5,
    "lag_push_off": 0.0,
    "lag_pitch": 0.0,
    "lag_capture": 0.0,
}
PLAN_BEFORE = {"pitch_least": -10.0, "back_beyond": 1.0}
"""What was not searched at first, of the legs and of the rule, with the numbers that walks had then."""
BACK = ("pitch_gain", "knee", "knee_stiffness", "knee_damping")
"""Of these numbers of the swing, a step back had none of its own before."""
STEADY = ("length", "duration", "capture")
"""Of these, what stands elsewhere: the nominal step, and the capture point as it ends (`unpack`)."""
RANGES = LEGS | RULE
SHIPPED = "shipped"
"""In place of a file: the walk of the default configuration."""
ROUGH = {
    "hip_damping": 240.0, "pitch_nominal": 0.14, "pitch_offset": -0.071, "pitch_capture_gain": 0.0,
    "hip_rate_max": 6.3, "hip_speed_min": -0.32, "knee_stiffness": 980.0, "knee_damping": 56.0,
    "knee_loading": 0.4, "knee_standing": 0.33, "knee_seconds": 0.34, "ankle_stiffness": 380.0,
    "ankle_slack": 0.2, "ankle_damping": 6.1, "ankle_capture_gain": 0.0, "push_off_angle": 0.23,
    "push_off_ramp": 0.16, "push_off_torque": 150.0, "push_off_gain": 270.0, "push_off_ankle": 0.23,
    "toe_off_seconds": 0.062, "swing_stiffness": 220.0, "swing_damping": 120.0, "swing_pitch_gain": 1.3,
    "swing_rate_max": 9.0, "swing_knee": 0.69, "swing_knee_stiffness": 3.3, "swing_knee_damping": 11.0,
    "landing_knee": 0.29, "landing_knee_stiffness": 190.0, "landing_knee_damping": 13.0,
    "landing_seconds": 0.073, "swing_sole": -0.15, "swing_ankle_most": 0.3, "passing_seconds": 0.05,
    "back_ahead": 0.05, "back_force": 120.0, "back_toe_off": 0.5, "back_pitch_gain": 0.5,
    "toe_off_least": 0.2, "landing_behind": 0.05, "back_knee": 0.9,
    "length_speed": 0.3, "duration_speed": -0.2, "capture_speed": 0.3, "push_off_speed": 20.0,
    "swing_ankle_stiffness": 40.0, "swing_ankle_damping": 1.0,
    "back_knee_stiffness": 40.0, "back_knee_damping": 4.0, "balance_ankle": 0.3, "balance_sole": 0.2,
    "lag_seconds": 3.0, "lag_speed": 0.5, "lag_most": 0.5, "lag_push_off": 50.0, "lag_pitch": 0.1,
    "lag_capture": 0.2,
    "length": 0.89, "duration": 0.68, "capture": 0.41, "length_gain": -0.0064, "pitch_gain": 1.9,
    "pitch_least": -0.2, "duration_gain": 0.45, "duration_least": 0.31, "back_margin": 0.013,
    "back_reach": 0.038, "back_gain": 1.3, "back_least": 0.12, "back_speed": 3.0, "back_time": 0.23,
}  # fmt: skip
"""Where a search begins: a walk that is too slow and falls backward at 30 N s."""

HARD_PHASES, HARD_CALM = 6, 3
"""Walkers pushed by each impulse, and unpushed, in each of `HARD`."""


@dataclass(frozen=True)
class Plan:
    """Whom each is tried on: ``calm`` walkers unpushed, one pushed by each impulse at each phase; phases
    shift by a part of their distance from turn to turn, impulses are weaker by up to that share. ``hard``:
    which of `HARD` some meet besides."""

    impulses: tuple[float, ...] = tuple(PUSHES)
    calm: int = 12
    phases: int = 12
    offsets: int = 4
    weaker: float = WEAKER
    seconds: float = 9.0
    hard: tuple[str, ...] = tuple(HARD)


@dataclass(frozen=True)
class Args:
    """Find a walk."""

    minutes: float = 15.0
    """How long is searched."""
    population: int = 32
    """Candidates a generation."""
    sigma: float = 0.08
    """First step size, share of each range."""
    seed: int = 0
    """Of CMA-ES."""
    weight: float = 1.0
    """Of unpushed walking against pushes."""
    begin: str = ""
    """Where the search begins: what one found before (JSON), or `shipped`; `ROUGH` if not given."""
    out: Path = Path("tuned.json")
    """Where what is found goes (JSON)."""


def unpack(unit: np.ndarray) -> tuple[dict[str, Any], dict[str, Any]]:
    """[K] numbers of the legs and of the step plan, from [K, n] points of the unit cube."""
    values = {
        name: (low + (high - low) * unit[:, i]).astype(np.float32)
        for i, (name, (low, high)) in enumerate(RANGES.items())
    }
    legs, own = {n: values[n] for n in LEGS}, {n: values[n] for n in RULE}
    return legs | {"landing_time": own["duration"], "landing_capture": own["capture"]}, own


def pack(numbers: dict[str, float]) -> np.ndarray:
    """[n] the point of the unit cube that stands for these numbers."""
    low, high = np.array(list(RANGES.values())).T
    return np.clip((np.array([numbers[n] for n in RANGES]) - low) / (high - low), 0.001, 0.999)


def filled(told: dict[str, Any]) -> dict[str, Any]:
    """What a search found, its legs and rule with what was not searched then."""
    legs = told["legs"]
    swing = {f"back_{name}": legs[f"swing_{name}"] for name in BACK if f"swing_{name}" in legs}
    return told | {"legs": BEFORE | swing | legs, "rule": PLAN_BEFORE | told["rule"]}


def of_config(config: Config) -> dict[str, Any]:
    """The walk of ``config``, as what a search finds is written."""
    gait = config.gait
    steady = gait.length_nominal, gait.duration_nominal, gait.compliant.landing_capture
    rule = {n: getattr(gait.step_plan, n) for n in RULE if n not in STEADY}
    landing = {"landing_time": gait.duration_nominal, "landing_capture": gait.compliant.landing_capture}
    legs = {n: getattr(gait.compliant, n) for n in LEGS} | landing
    return {"legs": legs, "rule": dict(zip(STEADY, steady, strict=True)) | rule, "options": {}}


class Trials:
    """Walks [K] candidates through the same pushes."""

    def __init__(self, config: Config, candidates: int, plan: Plan = Plan()) -> None:
        self.config, self.candidates, self.plan = rules.configured(config, Replan()), candidates, plan
        cases = [(i, p / plan.phases, "") for i in plan.impulses for p in range(plan.phases)]
        cases += [(0.0, 0.0, "")] * plan.calm
        for name in plan.hard:
            for impulse, _ in HARD[name].prices:
                many = HARD_PHASES if impulse else HARD_CALM
                cases += [(impulse, p / many, name) for p in range(many)]
        self.impulse, self.phase = np.array([case[:2] for case in cases], np.float32).T
        self.where = np.array([case[2] for case in cases])
        met = [HARD[name] if name else Circumstance() for name in self.where]
        self.speed, self.noise, again = (
            np.array([getattr(x, n) for x in met], np.float32) for n in ("speed", "noise", "again")
        )
        self.again = np.round(again / config.physics.timestep).astype(np.int32)
        borne = [one.burden for one in met]
        borne = [  # half of them late by a quarter, a half, three quarters of it: a way there
            dataclasses.replace(one, delay=one.delay * min(1.0, (i % 6 + 1) / 4))
            for i, one in enumerate(borne)
        ]
        self.burden = jax.tree.map(lambda *each: np.array(each, np.float32), *borne) if plan.hard else None
        self.size = len(cases)
        task, mesh = dataclasses.replace(Task.of(self.config), episode_ticks=2**30), devices.mesh()
        self.windows = round(plan.seconds / task.setup.timestep / task.setup.window_ticks)

        def begin(numbers: Any, scenario: Any) -> Tried:
            return exertion.begin(trials.begin(task, numbers, scenario))

        def advance(profile: Profile, tried: Tried) -> Tried:
            def window(_: int, one: Tried) -> Tried:
                decided = stepper.decide(one.trial.state, jnp.zeros(2))  # the plan stands as it is
                one = one.replace(trial=one.trial.replace(state=decided))
                return backend.scan(
                    task.setup, exertion.alone, task, task.setup.window_ticks, one, profile,
                    otherwise=lambda: _by_xla(task, one, profile),
                )[0]  # fmt: skip

            return jax.lax.fori_loop(0, self.windows, window, tried)

        self._begin = devices.spread(jax.vmap(begin), mesh, (True, True))
        self._advance = devices.spread(
            lambda p, t: devices.each(advance, p, t, block=backend.block(task.setup)), mesh, (True, True)
        )

    def __call__(self, legs: dict[str, Any], rule: dict[str, Any], turn: int = 0) -> Tried:
        """The walks [K, M] of K candidates' numbers; ``turn`` shifts phases and noise."""
        many = self.candidates * self.size
        gait = jax.tree.map(lambda x: np.full(many, x, np.float32), self.config.gait)
        legs, rule = ({n: np.repeat(x, self.size) for n, x in own.items()} for own in (legs, rule))
        steps = {name: value for name, value in rule.items() if name not in STEADY}
        numbers = dataclasses.replace(
            gait,
            compliant=dataclasses.replace(gait.compliant, **legs),
            step_plan=dataclasses.replace(gait.step_plan, **steps),
            length_nominal=rule["length"],
            duration_nominal=rule["duration"],
            speed_desired=np.tile(self.speed, self.candidates),
        )
        plan = self.plan
        phase = self.phase + (turn % plan.offsets + 0.5) / plan.offsets / plan.phases
        keys = scenarios.keys(turn, scenarios.TUNE, self.size)
        # The golden ratio's multiples fill the interval evenly.
        impulse = self.impulse * (1 - plan.weaker * (turn * 0.618034 % 1))
        scenario = scenarios.batch(self.config, impulse, phase, keys).replace(
            burden=jax.tree.map(jnp.asarray, self.burden),
            noise=jnp.asarray(self.noise),
            again=jnp.asarray(self.again),
        )
        tiled = jax.tree.map(lambda x: jnp.concatenate([x] * self.candidates), scenario)
        profile = Profile(jnp.zeros((many, BINS)), jnp.asarray(rule["duration"]))
        tried = self._begin(numbers, tiled)
        tried = self._advance(profile, tried)
        kept = tried.replace(trial=trials.without_keys(tried.trial))
        return jax.tree.map(lambda x: np.asarray(x).reshape(self.candidates, self.size, *x.shape[1:]), kept)


def _by_xla(task: Task, one: Tried, profile: Profile) -> tuple[Tried, None]:
    def on(_: int, tried: Tried) -> Tried:
        return exertion.tick(task, tried, profile)

    return jax.lax.fori_loop(0, task.setup.window_ticks, on, one), None


def measures(config: Config, walked: Tried) -> dict[str, np.ndarray]:
    """[K] means over the unpushed walkers [K, C] of each candidate."""
    tally, done = walked.trial.tally, walked.exertion
    weight = config.body.mass * GRAVITY
    seconds, way = np.maximum(tally.seconds, 1e-3), np.maximum(tally.distance, 0.05)
    steps = np.maximum(tally.steps, 1)
    speed = tally.distance / seconds
    high, low = done.pitch_high, done.pitch_low
    knee = np.degrees(done.loading / steps)
    told = {
        "speed": speed,
        "joint_work": done.joint_work / way / weight,
        "leg_work": done.leg_work / way / weight,
        "force": done.force / weight,
        "knee": knee,
        "double": done.double / seconds,
        "step": tally.step_length / steps,
        "seconds": tally.step_seconds / steps,
        "hip_moment": done.hip_moment / config.body.mass,
        "hip_power": done.hip_power / config.body.mass,
        "pitch_range": high - low,
        "pitch_mean": np.abs(tally.pitch / seconds),
        "passing": np.degrees(done.passing),
        "standing": np.degrees(done.standing / steps),
        "dorsiflexion": np.degrees(done.dorsiflexion),
    }
    found = {name: np.asarray(value).mean(1) for name, value in told.items()}
    return found | {
        "speed_off": np.abs(found["speed"] - config.gait.speed_desired),
        "knee_too_straight": -found["knee"],
        "knee_too_bent": found["knee"],
        "double_too_short": -found["double"],
        "step_too_short": -found["step"],
        "step_too_long": found["step"],
        "passing_too_straight": -found["passing"],
    }


def costs(bench: Trials, walked: Tried, weight: float) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """[K] of the candidates, and what they come from."""
    usual = bench.where == ""
    calm = (bench.impulse == 0) & usual
    found = measures(bench.config, jax.tree.map(lambda x: x[:, calm], walked))
    up = ~np.asarray(walked.trial.state.terminated)
    life = np.minimum(walked.trial.tally.fall_seconds / bench.plan.seconds, 1.0)
    total = weight * sum(goal.cost(found[name]) for name, goal in GOALS.items())
    total = total + FALL * (1 - up[:, calm].mean(1)) + 2 * FALL * (1 - life[:, calm].mean(1))
    for name in bench.plan.hard:
        own = (bench.where == name) & (bench.impulse == 0)
        tally = walked.trial.tally
        speed = np.asarray(tally.distance / np.maximum(tally.seconds, 1e-3))[:, own].mean(1)
        total = total + 2 * HARD[name].off.cost(np.abs(speed - HARD[name].speed))
        found[f"{name} m/s"] = speed
    asked = {"": tuple(PUSHES.items()), **{name: HARD[name].prices for name in bench.plan.hard}}
    for name, prices in asked.items():
        for impulse, price in prices:
            own = (bench.where == name) & (bench.impulse == impulse)
            lost, early = 1 - up[:, own].mean(1), 1 - life[:, own].mean(1)
            found[f"{name}{impulse:+.0f}"] = 1 - lost
            total = total + price * (lost + 0.3 * early)
    return np.where(np.isfinite(total), total, 1e3), found


SHOWN = ("speed", "step", "seconds", "joint_work", "leg_work", "force", "knee", "double", "hip_moment",
         "hip_power", "pitch_range", "pitch_mean", "passing", "standing", "dorsiflexion")  # fmt: skip


def line(found: dict[str, np.ndarray], which: int) -> str:
    """One candidate in a line."""
    told = " ".join(f"{name} {found[name][which]:.3g}" for name in SHOWN)
    survived = [f"{n}:{x[which]:.2f}" for n, x in found.items() if n[-1].isdigit() or n.endswith("m/s")]
    return told + "  " + " ".join(survived)


def main(args: Args) -> None:
    """Search until the time is over; write the mean that it has come to, and the way there."""
    if args.minutes <= 0:
        sys.exit(f"--minutes {args.minutes:g}: give a number above 0")
    if args.begin not in ("", SHIPPED) and not Path(args.begin).is_file():
        sys.exit(f"--begin {args.begin}: give a file that this script wrote, or shipped")
    config = PRESETS["default"]
    bench = Trials(config, args.population)
    start = dict(ROUGH)
    if args.begin:
        told = (
            of_config(config) if args.begin == SHIPPED else filled(json.loads(Path(args.begin).read_text()))
        )
        start |= {n: x for n, x in (told["legs"] | told["rule"]).items() if n in RANGES}
    bounds = np.tile([0.0, 1.0], (len(RANGES), 1))
    cma = cmaes.SepCMA(
        pack(start), args.sigma, bounds=bounds, population_size=args.population, seed=args.seed
    )
    begun, turn = time.monotonic(), 0
    while time.monotonic() - begun < 60 * args.minutes:
        units = np.array([cma.ask() for _ in range(args.population)])
        cost, found = costs(bench, bench(*unpack(units), turn), args.weight)
        cma.tell([(unit, float(one)) for unit, one in zip(units, cost, strict=True)])
        if turn % 10 == 0:
            best = int(np.argmin(cost))
            told = f"{turn} {time.monotonic() - begun:.0f} s {np.median(cost):.2f} {cost[best]:.2f}"
            print(told, line(found, best), flush=True)
            _write(args, cma.mean, float(np.median(cost)))
        turn += 1
    _write(args, cma.mean, float(np.median(cost)))


def _write(args: Args, mean: np.ndarray, cost: float) -> None:
    legs, rule = unpack(mean[None])
    told = {"cost": cost, "legs": {n: round(float(x[0]), 5) for n, x in legs.items()},
            "rule": {n: round(float(x[0]), 5) for n, x in rule.items()},
            "options": {n: str(v) if isinstance(v, Path) else v for n, v in vars(args).items()}}  # fmt: skip
    files.write_json(args.out, told)


if __name__ == "__main__":
    runtime.setup()
    main(tyro.cli(Args, description=__doc__))
