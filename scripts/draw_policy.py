"""Draw what a policy changes of the planned step, over where in the step a walker is and how fast it goes.

    python scripts/draw_policy.py shipped --out docs/results/policy.png

Walkers are pushed as in training; each cell is the mean of what was answered there. The rule `replan` changes
nothing, so that what is drawn is what was learned.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import jax
import numpy as np
import tyro

from jaxwalk.common import figures, runtime
from jaxwalk.learn.policies import named
from jaxwalk.learn.policies.named import Subject
from jaxwalk.task import collect, scenarios, spawn
from jaxwalk.task.stepper import Stepper, Task

BINS, LEAST = (24, 24), 10  # cells; of what fewer walkers came to nothing is drawn
RANGES = ((0.0, 0.75), (-0.6, 2.4))  # s since the touch-down, m/s


@dataclass(frozen=True)
class Args:
    """Draw what a policy changes of the planned step."""

    policy: tyro.conf.Positional[str] = "shipped"
    """A run folder, a policy file, or shipped."""
    out: Path = Path("policy.png")
    """The picture."""
    walkers: int = 1024
    """Who are followed."""
    seconds: float = 30.0
    """For so long."""
    seed: int = 0
    """Of their starts, pushes and noise."""


def asked(subject: Subject, args: Args) -> tuple[np.ndarray, np.ndarray]:
    """[N, O] what walkers saw when they were asked, [N, 2] what was answered."""
    config, task = subject.config, Task.of(subject.config)
    windows = round(args.seconds / config.physics.timestep / config.train.window_ticks)

    def on(states: Stepper, key: Any) -> tuple[Stepper, Any]:
        act = jax.vmap(partial(subject.act, subject.params))
        told = states.observation, act(states.observation), states.asked
        keys = jax.random.split(key, args.walkers)
        return collect.window(config, task, states, lambda o, _: act(o), keys)[0], told

    @jax.jit
    def walk(key: Any) -> Any:
        begin, keys = jax.random.split(key)
        states = jax.vmap(partial(spawn.walker, config, task))(jax.random.split(begin, args.walkers))
        return jax.lax.scan(on, states, jax.random.split(keys, windows))[1]

    seen, answered, was = jax.device_get(walk(scenarios.root(args.seed, scenarios.RECORDED)))
    return seen[was], answered[was]


def main(args: Args) -> None:
    """Follow, draw."""
    subject = named.load(args.policy)
    if subject.config.gait.steps != "planned" or not {"speed", "elapsed"} <= set(subject.config.observation):
        sys.exit(f"{args.policy}: give a policy on planned steps that is told speed and elapsed")
    seen, answered = asked(subject, args)
    index = {name: i for i, name in enumerate(subject.config.observation)}
    place = seen[:, index["elapsed"]], seen[:, index["speed"]]
    count, *edges = np.histogram2d(*place, bins=BINS, range=RANGES)
    figure = figures.new_figure(10.0, 4.2)
    for axes, which, most, title in zip(
        figure.subplots(1, 2, sharey=True), (0, 1), subject.config.gait.answers[1],
        ("change of length, m", "change of time, s"), strict=True,
    ):  # fmt: skip
        sums = np.histogram2d(*place, bins=BINS, range=RANGES, weights=np.clip(answered[:, which], -1, 1))[0]
        mean = np.where(count >= LEAST, most * sums / np.maximum(count, 1), np.nan)
        drawn = axes.pcolormesh(*edges, mean.T, cmap="RdBu_r", vmin=-most, vmax=most)
        figure.colorbar(drawn, ax=axes)
        axes.set_title(title, loc="left")
        axes.set_xlabel("time since touch-down, s")
    figure.axes[0].set_ylabel("speed of the torso, m/s")
    figures.write_png(figure, args.out)


if __name__ == "__main__":
    runtime.setup()
    main(tyro.cli(Args, description=__doc__))
