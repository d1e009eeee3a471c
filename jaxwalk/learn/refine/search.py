"""The search: candidates differ in the actor's last layer, and walk under the pushes that rank policies.

What DDPG climbs is the return of walkers that explore, all of them at once: a push that nearly everybody
holds weighs little in it, while one such push decides a threshold. The evolution strategy (separable CMA-ES:
Ros and Hansen 2008) climbs the graded pushes' own score, without exploration, from a policy that is good
already: of its features it changes what is made of them. With one walker at each phase the worst of sixteen
is a share of pushes that nobody fell from: a harder score than that of an evaluation, which has more walkers.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass

import cmaes
import jax
import numpy as np
from jax.flatten_util import ravel_pytree

from jaxwalk.common.parallel import devices
from jaxwalk.config import Config
from jaxwalk.learn import evolution
from jaxwalk.learn.policies import policy
from jaxwalk.learn.policies.policy import Policy
from jaxwalk.learn.train import finals
from jaxwalk.learn.train.evaluation import Exam, Marks
from jaxwalk.task import scenarios

_LAST = "output"
WAY = 0.5
"""How much is gone of the way from the policy that was given to the search's mean, in which chance has its
part (weights between two policies: Wortsman et al. 2022)."""


@dataclass(frozen=True)
class Refined:
    """What came of it.

    Attributes:
      policy: what was found, with the origin of the one that was given.
      before, after: marks of the one that was given and of this one, under pushes, starts and noise that
        neither training nor the search has met.
    """

    policy: Policy
    before: Marks
    after: Marks

    @property
    def better(self) -> bool:
        """Whether anything was gained."""
        return self.after.score > self.before.score


def run(
    config: Config,
    trained: Policy,
    seed: int,
    generations: int,
    candidates: int,
    sigma: float,
    tell: Callable[[int, float], bool] = lambda generation, score: False,
) -> Refined:
    """Search from ``trained``, and hold what is found against it.

    Args:
      config: of the training that it came from.
      seed: of candidates, starts and noise.
      candidates: of a generation; all walk under the same pushes, one walker at each phase of each.
      sigma: first step size, in units of the last layer's numbers.
      tell: called after each generation with its number and mean score; gives whether it is the last.
    """
    mesh = devices.mesh()
    exam = Exam(config, policy.act, mesh, seed, scenarios.TUNE, replicas=1)
    given = policy.without_origin(trained)
    first, unravel = ravel_pytree(given.actor[_LAST])

    def of(numbers: np.ndarray) -> Policy:
        last = unravel(jax.numpy.asarray(numbers, jax.numpy.float32))
        return dataclasses.replace(given, actor={**given.actor, _LAST: last})

    search = cmaes.SepCMA(np.asarray(first, np.float64), sigma, population_size=candidates, seed=seed)
    for generation in range(1, generations + 1):
        exam.renew(seed + generation)
        asked = [search.ask() for _ in range(candidates)]
        scores = np.array([exam(of(one))[0].score for one in asked])
        told = evolution.tell(search, asked, scores)
        if tell(generation, float(np.mean(told))):
            break
    start = np.asarray(first, np.float32)
    found = of(start + np.float32(WAY) * (np.asarray(search.mean, np.float32) - start))
    last = finals.examination(config, policy.act, mesh, seed, scenarios.REFINED)
    before, after = last(given)[0], last(found)[0]
    return Refined(dataclasses.replace(found, metadata=trained.metadata), before, after)
