"""One examination of several runs, each in its lane: the trials of all of them in one program."""

from __future__ import annotations

from collections.abc import Sequence

import jax
import jax.numpy as jnp
import numpy as np
from jax.sharding import Mesh

from jaxwalk.config import Config
from jaxwalk.learn.train import evaluation, lanes
from jaxwalk.learn.train.evaluation import Exam, Marks
from jaxwalk.task.stepper import Task
from jaxwalk.task.trials import Params, Trial


class Exams:
    """The examinations of runs that differ in their seed alone.

    Args:
      exams: of each run; their own runners stay unused.
    """

    def __init__(self, config: Config, exams: Sequence[Exam], mesh: Mesh) -> None:
        self._exams, self._mesh, self._gait = exams, mesh, config.gait
        count = len(exams[0].is_calm)
        self._runner = lanes.LaneRunner(Task.of(config), exams[0].act, count, mesh, lanes.one_by_one())
        filled = lanes.filled([exam.scenarios for exam in exams], mesh)
        self._scenarios = jax.tree.map(lambda *x: jnp.stack(x, axis=1), *filled)

    def __call__(self, params: Sequence[Params], live: Sequence[bool]) -> list[tuple[Marks, Trial]]:
        """Marks and trials of every run; of one that is not live they mean nothing.

        Args:
          params: of each run, on whatever device.
        """
        host = [jax.tree.map(np.asarray, one) for one in lanes.filled(params, self._mesh)]
        together = jax.tree.map(lambda *x: np.stack(x), *host)
        trials = self._runner.run(
            (lanes.flags(live, self._mesh), together),
            self._gait,
            self._exams[0].profile,
            self._scenarios,
            evaluation.SECONDS,
        )
        own = [jax.tree.map(lambda x, lane=lane: x[:, lane], trials) for lane in range(len(self._exams))]
        return [(exam.mark(trials), trials) for exam, trials in zip(self._exams, own, strict=True)]
