"""How many of the pushes that the plan loses any change of its steps could hold: what there is to learn.

python scripts/ceiling.py [--impulses 130,145,155,-125,-140,-155] [--replicas 6]

Of each walker that the plan (`replan`) loses, the answers of the 1.4 s after its push are searched by the
cross-entropy method (Rubinstein 1999), each time from the same start with the same noise: not a policy, for
it knows what will come, but a bound from below on what a policy that knew as much could hold.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from rich.console import Console
from rich.table import Table

from jaxwalk.common.errors import UserError
from jaxwalk.common.parallel import devices
from jaxwalk.config import Config
from jaxwalk.learn.train import evaluation
from jaxwalk.options import checks
from jaxwalk.options.parse import Numbers, reader
from jaxwalk.task import backend, scenarios, trials
from jaxwalk.task.stepper import Task
from jaxwalk.task.trials import Trial

ANSWERS, CANDIDATES, ELITE = 14, 48, 8
SPREAD, LEAST_SPREAD, KEPT = 0.6, 0.15, 0.3  # of answers at first and at least; of the last generation's law
BEFORE, AFTER = 3.0, 5.5  # s: before the first push can come; until it is told who walks on


@dataclass(frozen=True)
class Args:
    """How many of the pushes that the plan loses any change of its steps could hold."""

    impulses: Numbers = evaluation.IMPULSES["compliant"]
    """Pushes, N s; positive ones push forward."""
    replicas: int = 6
    """Walkers for each impulse and phase."""
    generations: int = 6
    """Of 48 candidates each."""
    seed: int = 0
    """Of the starts and the noise."""

    def check(self) -> None:
        """As `Options.check`."""
        checks.impulses("--impulses", self.impulses)
        checks.between("--replicas", self.replicas, 1, 64, "")
        checks.between("--generations", self.generations, 1, 1000, "")
        checks.seed(self.seed)


Walk = Callable[[Float[Array, "N K 2"], Trial, int], Trial]


def programs(config: Config) -> tuple[Callable[..., Trial], Walk]:
    """(scenarios -> trials at their start; [N, K, 2] answers after the push, trials, windows -> trials)."""
    task = Task.of(config).endless()
    block, profile = backend.block(task.setup), trials.Profile.blank()
    every = task.replan * task.setup.window_ticks

    def one(answers: Float[Array, "K 2"], trial: Trial, windows: int) -> Trial:
        def window(_: Array, trial: Trial) -> Trial:
            state = trial.state.walker
            number = (state.tick - state.push.start) // every
            due = (trial.touchdowns >= trials.PUSH_STEP) & (number >= 0) & (number < ANSWERS)
            answer = jnp.where(due, answers[jnp.clip(number, 0, ANSWERS - 1)], 0.0)
            return trials.advance(task, lambda given, _: given, answer, profile, jnp.int32(1), trial)

        return jax.lax.fori_loop(0, windows, window, trial)

    begin = jax.jit(lambda s: devices.each(partial(trials.begin, task, config.gait), s, block=block))
    walk = jax.jit(
        lambda answers, those, windows: devices.each(
            lambda a, t: one(a, t, windows), answers, those, block=block
        ),
        static_argnums=2,
    )
    return begin, walk


def scores(those: Trial) -> np.ndarray:
    """[N]: 100 for who walks on; else how long it was up, s, and of those still up the speed."""
    fell = np.asarray(those.tally.fall_seconds)
    late = np.where(np.isinf(fell), 20.0 + np.asarray(those.state.last.speed), np.minimum(fell, 20.0))
    return np.where(trials.walks_on(those), 100.0, late)


def saved(walk: Walk, before: Trial, windows: int, generations: int, seed: int) -> np.ndarray:
    """[M] of trials that the plan loses: whether any answers were found that it walks on with."""
    count, drawn = before.touchdowns.shape[0], np.random.default_rng(seed)
    mean, spread = np.zeros((count, ANSWERS, 2)), np.full((count, ANSWERS, 2), SPREAD)
    many = jax.tree.map(lambda x: jnp.repeat(x, CANDIDATES, axis=0), before)
    found = np.zeros(count, bool)
    for _ in range(generations):
        answers = mean[:, None] + spread[:, None] * drawn.standard_normal((count, CANDIDATES, ANSWERS, 2))
        answers = np.clip(answers, -1.0, 1.0).astype(np.float32)
        ends = jax.device_get(walk(jnp.asarray(answers.reshape(-1, ANSWERS, 2)), many, windows))
        told = scores(ends).reshape(count, CANDIDATES)
        found |= (told == 100.0).any(1)
        best = np.take_along_axis(answers, np.argsort(-told, 1)[:, :ELITE, None, None], 1)
        mean = KEPT * mean + (1 - KEPT) * best.mean(1)
        spread = np.maximum(KEPT * spread + (1 - KEPT) * best.std(1), LEAST_SPREAD)
    return found


def main(argv: list[str]) -> int:
    try:
        args = reader(Args, "ceiling")(argv)
    except UserError as error:
        print(f"ceiling: error: {error}", file=sys.stderr)
        return 2
    config = Config()
    phases = np.arange(evaluation.PHASES) / evaluation.PHASES
    cells = [(impulse, phase) for impulse in args.impulses for phase in phases]
    impulse, phase = np.array(cells * args.replicas, np.float32).T
    keys = scenarios.keys(args.seed, scenarios.PUSHED, len(impulse))
    begin, walk = programs(config)
    window = config.physics.timestep * config.train.window_ticks
    nothing = jnp.zeros((len(impulse), ANSWERS, 2))
    before = walk(nothing, begin(scenarios.batch(config, impulse, phase, keys)), round(BEFORE / window))
    rest = round(AFTER / window)
    plan = trials.walks_on(jax.device_get(walk(nothing, before, rest)))
    lost = np.flatnonzero(~plan)
    held = plan.copy()
    if len(lost):
        those = jax.tree.map(lambda x: x[lost], before)
        held[lost] = saved(walk, those, rest, args.generations, args.seed)
    table = Table("push, N s", "the plan holds", "some answers hold, at least")
    for one in args.impulses:
        own = impulse == one
        table.add_row(f"{one:+g}", f"{plan[own].mean():.0%}", f"{held[own].mean():.0%}")
    table.add_row("all", f"{plan.mean():.0%}", f"{held.mean():.0%}")
    Console().print(table)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
