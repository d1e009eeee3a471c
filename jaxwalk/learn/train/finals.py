"""The last examination: a run's best policies once more, under more pushes than those that ranked them.

The best of many small evaluations is partly the luckiest one, and they push so hard that a rare fall
under a small push goes unseen. The few best meet fresh starts and noise, and all sizes of push.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import jax
import jax.numpy as jnp
from jax.sharding import Mesh

from jaxwalk.config import Config, Form
from jaxwalk.learn.policies import policy
from jaxwalk.learn.policies.policy import Policy
from jaxwalk.learn.train.evaluation import Exam, Marks
from jaxwalk.model.engine import Setup
from jaxwalk.task import backend, scenarios
from jaxwalk.task.trials import Act

IMPULSES: dict[Form, tuple[float, ...]] = {
    "rigid": (40.0, 50.0, 60.0, 70.0, 80.0, -40.0, -50.0, -60.0, -80.0, -100.0),
    "compliant": (80.0, 125.0, 140.0, 150.0, 160.0, -80.0, -125.0, -140.0, -150.0, -160.0),
}
"""N s, by the legs."""
REPLICAS, MORE = 2, 10
"""Walkers at each phase of each; by native code more. The least of sixteen shares of few walkers is lower
than the worst phase's own: it ranks policies, and measures none."""


def examination(config: Config, act: Act, mesh: Mesh, seed: int, purpose: int = scenarios.FINALS) -> Exam:
    """What policies of one kind go through at the end of a run of ``seed``, or for another ``purpose``."""
    replicas = MORE if backend.native_here(Setup.of(config)) else REPLICAS
    return Exam(config, act, mesh, seed, purpose, IMPULSES[config.gait.form], replicas)


class Finals:
    """The best policies of one run so far, and how it is settled between them and the one that it began with:
    what was learned has to earn its place.

    Args:
      seed: of the run.
    """

    def __init__(self, config: Config, mesh: Mesh, seed: int) -> None:
        self._config, self._mesh, self._seed, self._most = config, mesh, seed, config.train.finalists
        self._entered: list[tuple[Policy, float]] = []

    def enter(self, candidate: Policy, score: float) -> None:
        """A policy and the score of its evaluation; those that cannot win any more are dropped.

        One whose score is not finite does not take part.
        """
        if not math.isfinite(score):
            return
        kept = jax.tree.map(jnp.copy, candidate)  # training donates its buffers
        ranked = sorted([*self._entered, (kept, score)], key=lambda one: -one[1])
        self._entered = [
            one for place, one in enumerate(ranked) if place < self._most or one[0].metadata.footsteps == 0
        ]

    @property
    def entered(self) -> list[tuple[int, float]]:
        """(footsteps, score) of those that can still win, the best first."""
        return [(one.metadata.footsteps, score) for one, score in self._entered]

    @property
    def finalists(self) -> list[Policy]:
        """Those that are to meet, the best first; none where fewer than two are to."""
        return [] if self._most < 2 else [one for one, _ in self._entered]

    def settle(self) -> list[tuple[Policy, Marks]]:
        """The finalists with their marks, as they are `examine`d, the winner first: see `settled`."""
        return self.settled(self.examine(self.finalists))

    def settled(self, marks: Sequence[Marks]) -> list[tuple[Policy, Marks]]:
        """The finalists with their ``marks``, the winner first; of equals, the one that was evaluated better.

        Empty where there are none: then the best evaluation stands.
        """
        return sorted(zip(self.finalists, marks, strict=False), key=lambda found: -found[1].score)

    def exam(self) -> Exam:
        """What the finalists are put through; its parameters are a policy without origin."""
        return examination(self._config, policy.act, self._mesh, self._seed)

    def examine(self, policies: Sequence[Policy]) -> list[Marks]:
        """The marks of each."""
        if not policies:
            return []
        exam = self.exam()
        return [exam(policy.without_origin(one))[0] for one in policies]
