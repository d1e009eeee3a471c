"""Find the constants of the footstep rules in ``jaxwalk/task/rules.py`` again, by CMA-ES.

    python scripts/tune_baselines.py --evaluations 40 --out rules.json

Each rule gets the same number of evaluations on the physics, sensors, pushes and score that settle between
a run's best policies, on starts and noise that neither training nor ``jaxwalk evaluate`` meets. The
constant step comes first: what undisturbed walking with it is like is measured, not searched, and the
other two start from that step, with small gains. The rule that decides steps anew is found together with the
legs, by ``scripts/tune.py``.
"""

from __future__ import annotations

import dataclasses
import json
import math
import time
from dataclasses import dataclass
from pathlib import Path

import cmaes
import numpy as np
import tyro

from jaxwalk.common import files, runtime
from jaxwalk.common.parallel import devices
from jaxwalk.config import Config, GaitConfig
from jaxwalk.learn.train import evaluation, finals
from jaxwalk.learn.train.evaluation import Exam, Marks
from jaxwalk.task import rules, scenarios
from jaxwalk.task.rules import CapturePoint, Constant, Raibert, Rule
from jaxwalk.task.trials import Trial

# What is searched, and within which bounds.
STEP = {"length": (0.4, 0.94), "duration": (0.45, 0.9)}
RANGES: dict[str, dict[str, tuple[float, float]]] = {
    "constant": STEP,
    "raibert": STEP | {"gain": (-0.2, 0.8)},
    "capture-point": STEP
    | {"length_gain": (-0.5, 1.5), "duration_gain": (-0.5, 0.5), "timing": (0.02, 50.0)},
}
LOGARITHMIC = ("timing",)
STARTS: dict[str, Rule] = {
    "constant": Constant(length=GaitConfig.length_nominal, duration=GaitConfig.duration_nominal),
    "raibert": Raibert(gain=0.1),
    "capture-point": CapturePoint(length_gain=0.1, duration_gain=0.0, timing=1.0),
}


@dataclass(frozen=True)
class Args:
    """Tune the footstep rules."""

    evaluations: int = 40
    """For each rule."""
    population: int = 8
    """Candidates a generation."""
    sigma: float = 0.2
    """First step size, share of each range."""
    phases: int = 8
    """Points of the step at which pushes begin."""
    seed: int = 0
    """Of the starts, the noise and CMA-ES."""
    out: Path = Path("rules.json")
    """Where what was found goes (JSON). Rules that are in it already are kept, and not searched again."""


def undisturbed(trials: Trial, calm: np.ndarray) -> dict[str, float]:
    """Constants of walking that nobody pushed: means over walkers, as the sensors tell them."""
    tally, up = trials.tally, calm & ~trials.state.terminated
    speed, desired, ahead = trials.state.observation[up].mean(0)  # of each one's last touch-down
    steps = tally.steps[up].sum()
    return {
        "step": float(tally.step_length[up].sum() / steps),
        "seconds": float(tally.step_seconds[up].sum() / steps),
        "com_ahead": float(ahead),
        "landing_speed": float(speed / desired),
    }


def changed(rule: Rule, values: dict[str, float]) -> Rule:
    """``rule`` with those of the values that it has."""
    own = {field.name for field in dataclasses.fields(rule)}
    return dataclasses.replace(rule, **{name: x for name, x in values.items() if name in own})


def tune(name: str, start: Rule, exam: Exam, args: Args) -> tuple[Rule, Marks, Trial]:
    """The best of all candidates, ``start`` among them."""
    ranges = RANGES[name]
    low, high = np.array([[_axis(field, x) for x in bounds] for field, bounds in ranges.items()]).T
    mean = (np.array([_axis(field, getattr(start, field)) for field in ranges]) - low) / (high - low)
    cma = cmaes.CMA(
        mean, args.sigma, bounds=np.tile([0.0, 1.0], (len(mean), 1)), population_size=args.population,
        seed=args.seed,
    )  # fmt: skip
    person = rules.reference(exam.config.gait)

    def examine(unit: np.ndarray) -> tuple[Rule, Marks, Trial]:
        at = dict(zip(ranges, low + unit * (high - low), strict=True))
        rule = changed(start, {f: math.exp(x) if f in LOGARITHMIC else float(x) for f, x in at.items()})
        return rule, *exam((rules.strong(rule), person))

    best = examine(mean)
    for _ in range(max(1, round((args.evaluations - 1) / args.population))):
        told = []
        for _ in range(args.population):
            unit = cma.ask()
            found = examine(unit)
            told.append((unit, -found[1].score))
            best = max(best, found, key=lambda one: one[1].score)
        cma.tell(told)
        print(f"  {best[1].score:.3f}  {best[1].speed:.3f} m/s  {best[0]}", flush=True)
    return best


def _axis(field: str, value: float) -> float:
    return math.log(value) if field in LOGARITHMIC else float(value)


def main(args: Args) -> None:
    evaluation.PHASES = args.phases
    config = rules.configured(Config(), Constant())
    exam = Exam(config, rules.act, devices.mesh(), args.seed, scenarios.TUNE, finals.IMPULSES["compliant"])
    before = json.loads(args.out.read_text()) if args.out.exists() else {}
    found: dict[str, dict] = before.get("rules", {})
    walk: dict[str, float] = before.get("undisturbed", {})
    for name, start in STARTS.items():
        if name in found:
            continue
        print(name, flush=True)
        begun = time.perf_counter()
        rule, marks, trials = tune(name, changed(start, walk), exam, args)
        if name == "constant":
            walk = dataclasses.asdict(rule) | undisturbed(trials, exam.is_calm)
        found[name] = {
            "rule": dataclasses.asdict(rule),
            "marks": dataclasses.asdict(marks),
            "seconds": time.perf_counter() - begun,
        }
        options = {**vars(args), "out": None}
        files.write_json(args.out, {"rules": found, "undisturbed": walk, "options": options})


if __name__ == "__main__":
    runtime.setup()
    main(tyro.cli(Args, description=__doc__))
