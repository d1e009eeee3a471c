"""The evaluation within training: graded pushes without exploration, one number to rank policies by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import jax
import numpy as np
from jax.sharding import Mesh

from jaxwalk.common.parallel import collectives, devices
from jaxwalk.config import Config, Form
from jaxwalk.learn.ddpg import learner
from jaxwalk.model.burdens import Burden
from jaxwalk.model.engine import Setup
from jaxwalk.task import backend, scenarios
from jaxwalk.task.stepper import Task
from jaxwalk.task.trials import Act, Params, Profile, Runner, Trial, walks_on

IMPULSES: dict[Form, tuple[float, ...]] = {
    "rigid": (60.0, 70.0, 80.0, -60.0, -80.0, -100.0),
    "compliant": (130.0, 145.0, 155.0, -125.0, -140.0, -155.0),
}
"""N s, by the legs: where some fall."""


@dataclass(frozen=True)
class Hardship:
    """Pushes, N s, and what they meet besides: instruments of torso and soles ``delay`` s late, motors of
    ``strength``; ``again``: s after which the push comes once more (0: it does not)."""

    impulses: tuple[float, ...]
    delay: float = 0.0
    strength: float = 1.0
    again: float = 0.0


HARDSHIPS: dict[Form, tuple[Hardship, ...]] = {
    "rigid": (),
    "compliant": (
        Hardship((60.0, 80.0, -65.0, -80.0), delay=0.02, strength=0.8),
        Hardship((60.0, -50.0, -70.0), again=1.0),
    ),
}
"""Met besides, by the legs: the plan alone holds them; a policy that is graded without them loses them."""
PHASES = 16
CALM = 16  # walkers that nobody pushes
PUSHED, MORE_CALM = 1_600, 64  # by native code: the survival's standard error is then below 1 % from 85 % on
SECONDS = 10.0
SPEED_TOLERANCE = 0.045  # m/s; the aim is 0.05


@dataclass(frozen=True)
class Marks:
    """How a policy did under the graded pushes.

    Attributes:
      score: mean of survival and worst, less falls of the calm and their speed's error.
      survival: share that walked on after its push. worst: the mean over pushes of that at the worst phase.
      calm: share of the unpushed that did not fall.
      speed: of the unpushed, m/s.
    """

    score: float
    survival: float
    worst: float
    calm: float
    speed: float


class Exam:
    """The graded pushes, the same ones each time until it is `renew`ed, for any policy of one kind.

    Each process takes an equal share of them on its own devices, and all know what came of all.

    Args:
      act: the policy on one observation; its parameters are handed over with each call.
      seed: of the starts and the noise.
      purpose: of the seed's keys, as in `scenarios`.
      impulses: N s, each at every phase; default `IMPULSES`; `HARDSHIPS` come besides.
      replicas: walkers for each of those; default: 1, or as many as come to `PUSHED` by native code.
    """

    def __init__(
        self,
        config: Config,
        act: Act,
        mesh: Mesh,
        seed: int,
        purpose: int = scenarios.ASSESS,
        impulses: Sequence[float] | None = None,
        replicas: int | None = None,
    ) -> None:
        self.config, self.act, self._mesh = config, act, mesh
        form = config.gait.form
        usual = Hardship(tuple(IMPULSES[form] if impulses is None else impulses))
        rows = [
            (impulse, phase / PHASES, met.delay, met.strength, met.again)
            for met in (usual, *HARDSHIPS[form])
            for impulse in met.impulses
            for phase in range(PHASES)
        ]
        native = backend.native_here(Setup.of(config))
        many, calm = (-(-PUSHED // len(rows)), MORE_CALM) if native else (1, CALM)
        replicas = many if replicas is None else replicas
        table = np.array(rows * replicas + [(0.0, 0.0, 0.0, 1.0, 0.0)] * calm, np.float32)
        impulse, phase, delay, strength, again = table.T
        burden = None
        if HARDSHIPS[form]:
            burden = Burden(0.0, 0.0, 0.0, 0.0, config.physics.friction, 0.0, strength, delay)
        # Calm names the policy, not the sensors: those are as noisy as in training.
        keys = scenarios.keys(seed, purpose, len(table))
        self.scenarios = scenarios.batch(config, impulse, phase, keys, burden=burden, again=again)
        self._purpose = purpose
        self.is_calm = impulse == 0
        self._cells = len(rows)
        self.runner = Runner(Task.of(config), act, len(collectives.share(len(table))), devices.local(mesh))
        self.profile = Profile.blank()

    def __call__(self, params: Params) -> tuple[Marks, Trial]:
        """Run all scenarios, without exploration; ``params`` are the same on whatever devices they are."""
        mine, params = collectives.share(len(self.is_calm)), devices.here(params, self._mesh)
        own = jax.tree.map(lambda x: x[mine], self.scenarios)
        trials = collectives.gather(self.runner.run(params, self.config.gait, self.profile, own, SECONDS))
        trials = jax.tree.map(lambda x: x[: len(self.is_calm)], trials)
        return self.mark(trials), trials

    def renew(self, seed: int) -> None:
        """From now on the starts and the noise of another ``seed``."""
        keys = scenarios.keys(seed, self._purpose, len(self.is_calm))
        self.scenarios = self.scenarios.replace(key=keys)

    def mark(self, trials: Trial) -> Marks:
        """What the scenarios' trials tell."""
        up, calm = ~trials.state.terminated, self.is_calm
        # A trial whose push was never reached counts by its walk alone.
        walks = walks_on(trials)
        survival, quiet = float(walks[~calm].mean()), float(up[calm].mean())
        cells = walks[~calm].reshape(-1, self._cells).mean(0).reshape(-1, PHASES)  # by push and phase
        worst = float(cells.min(1).mean())
        seconds = np.maximum(trials.tally.seconds[calm], 1e-3)
        speed = float((trials.tally.distance[calm] / seconds).mean())
        off = max(0.0, abs(speed - self.config.gait.speed_desired) - SPEED_TOLERANCE)
        score = (survival + worst) / 2 - (1.0 - quiet) - 8.0 * off
        return Marks(score, survival, worst, quiet, speed)


def of_learner(config: Config, mesh: Mesh, seed: int) -> Exam:
    """What the learner of a run goes through time and again; its parameters are the learner."""
    return Exam(config, lambda state, observation: learner.act(config.ddpg, state, observation), mesh, seed)
