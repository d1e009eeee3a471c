"""The evaluation within training: graded pushes without exploration, one number to rank policies by."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jax.sharding import Mesh

from jaxwalk import scenarios
from jaxwalk.config import Config
from jaxwalk.ddpg import learner
from jaxwalk.ddpg.learner import LearnerState
from jaxwalk.stepper import Task
from jaxwalk.trials import BINS, Profile, Runner, Trial

IMPULSES = (50.0, 60.0, 70.0, -50.0, -65.0, -80.0)
PHASES = 16
CALM = 16  # walkers that nobody pushes
SECONDS = 8.0
SPEED_TOLERANCE = 0.045  # m/s; the aim is 0.05


@dataclass(frozen=True)
class Assessment:
    """What an evaluation found.

    Attributes:
      score: mean survival under pushes, less falls of the calm and their speed's error.
      survival: share that outlived its push. calm: share of the unpushed that did not fall.
      speed: of the unpushed, m/s.
      predicted, real: discounted return from the first decision, as the critic believed and as it
        came (what lies beyond the evaluation is the critic's word).
    """

    score: float
    survival: float
    calm: float
    speed: float
    predicted: float
    real: float


class Assessor:
    """Evaluates learners of one run on the same scenarios each time."""

    def __init__(self, config: Config, mesh: Mesh, seed: int) -> None:
        self.config = config
        rows = [(impulse, phase / PHASES) for impulse in IMPULSES for phase in range(PHASES)] + [
            (0.0, 0.0)
        ] * CALM
        impulse, phase = np.array(rows, np.float32).T
        count = len(rows)
        # Calm names the policy, not the sensors: those are as noisy as in training.
        self.scenarios = scenarios.batch(
            config, impulse, phase, scenarios.keys(seed, scenarios.ASSESS, count)
        )
        self._impulse = impulse
        self._runner = Runner(
            Task.of(config),
            lambda state, observation: learner.act(config.ddpg, state, observation),
            count,
            mesh,
        )
        self._profile = Profile(jnp.zeros(BINS), jnp.float32(0.6))
        self._value = jax.jit(
            lambda state, o: learner.value(config.ddpg, state, o, learner.act(config.ddpg, state, o))
        )

    def __call__(self, state: LearnerState) -> Assessment:
        """Run all scenarios with the learner's actor, without exploration."""
        numbers = self.config.gait
        return self._judge(state, self._runner.run(state, numbers, self._profile, self.scenarios, SECONDS))

    def _judge(self, state: LearnerState, trials: Trial) -> Assessment:
        up = ~trials.state.terminated
        calm = self._impulse == 0
        # A trial whose push was never reached counts by its fall alone.
        survival, quiet = float(up[~calm].mean()), float(up[calm].mean())
        seconds = np.maximum(trials.tally.seconds[calm], 1e-3)
        speed = float((trials.tally.distance[calm] / seconds).mean())
        predicted = np.asarray(self._value(state, trials.first))
        beyond = np.asarray(self._value(state, trials.state.observation))
        real = trials.earned + trials.weight * np.where(up, beyond, 0.0)
        off = max(0.0, abs(speed - self.config.gait.speed_desired) - SPEED_TOLERANCE)
        return Assessment(
            score=survival - (1.0 - quiet) - 8.0 * off,
            survival=survival,
            calm=quiet,
            speed=speed,
            predicted=float(predicted.mean()),
            real=float(real.mean()),
        )
