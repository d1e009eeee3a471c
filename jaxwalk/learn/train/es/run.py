"""``jaxwalk train --learner es``: a run whose policies an evolution strategy finds."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

import cmaes
import jax
import numpy as np

from jaxwalk.common.interrupt import Stop
from jaxwalk.common.parallel import devices
from jaxwalk.config import Config
from jaxwalk.learn import evolution
from jaxwalk.learn.policies import policy
from jaxwalk.learn.policies.policy import Policy
from jaxwalk.learn.runs.progress import Progress
from jaxwalk.learn.runs.run_folder import RunFolder
from jaxwalk.learn.train.es import population
from jaxwalk.learn.train.es.population import Shape
from jaxwalk.learn.train.examined import Examined
from jaxwalk.task import backend, collect, scenarios


def run(config: Config, run_dir: Path | None, seed: int, command: str) -> Path:
    """Search, and return the run folder.

    What a candidate is judged by is what `jaxwalk.learn.ddpg` learns from: the reward of training's own
    walkers under training's own pushes, undiscounted. Ctrl-C (or SIGTERM, SIGHUP) ends after the generation
    under way and keeps the best policy so far.

    Raises:
      UserError: a configuration that cannot be run, or a folder that cannot be used.
    """
    collect.check(config)
    mesh = devices.mesh(config.es.candidates)
    with RunFolder.create(run_dir, config, seed, command) as folder:
        print(
            f"run folder {folder.path}, devices ({jax.devices()[0].platform}): {mesh.size}, "
            f"stepped by {backend.stepper_of(config)}",
            flush=True,
        )
        own = config.es
        steps = own.candidates * own.walkers * own.seconds / config.gait.duration_nominal
        with Progress(round(own.generations * steps)) as progress, Stop() as stop:
            examined = Examined(config, mesh, seed, folder, progress, stop)
            _search(config, seed, command, examined, progress, stop)
            examined.finish({"algorithm": "es", "settings": asdict(own)})
        return folder.path


def _search(
    config: Config, seed: int, command: str, examined: Examined, progress: Progress, stop: Stop
) -> None:
    kind, own = population.shape(config, seed), config.es
    earn = population.earning(config, kind, devices.mesh(own.candidates))
    search = cmaes.SepCMA(
        np.asarray(kind.first, np.float64), own.sigma, population_size=own.candidates, seed=seed
    )
    key, footsteps, told = scenarios.root(seed, scenarios.TUNE), 0, {}
    every = max(1, round(own.generations / config.train.evaluations))
    for generation in range(own.generations + 1):
        last = generation == own.generations or stop.wanted
        if generation % every == 0 or last:
            handed = _policy(config, kind, search.mean, seed=seed, command=command, footsteps=footsteps)
            if examined.report(handed, told) or last:
                return
        asked = np.stack([search.ask() for _ in range(own.candidates)])
        earned, landed = earn(asked, jax.random.fold_in(key, generation)).T
        earned = evolution.tell(search, list(asked), earned)
        footsteps += round(float(landed.sum()))
        told = {"train/reward": float(earned.mean())}
        progress.update(footsteps, told)


def _policy(config: Config, kind: Shape, numbers: np.ndarray, **origin: Any) -> Policy:
    actor = kind.unravel(jax.numpy.asarray(numbers, jax.numpy.float32))
    return policy.of_parts(config, actor, kind.mean, kind.std, clip=None, score=None, **origin)
