"""A run whose learner hands out policies now and then: each is examined, the best is kept."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Mapping
from typing import Any

from jax.sharding import Mesh

from jaxwalk.common import figures
from jaxwalk.common.interrupt import Stop
from jaxwalk.config import Config
from jaxwalk.learn.policies import policy
from jaxwalk.learn.policies.policy import Policy
from jaxwalk.learn.runs import picture
from jaxwalk.learn.runs.progress import Progress
from jaxwalk.learn.runs.run_folder import RunFolder
from jaxwalk.learn.train.evaluation import Exam, Marks
from jaxwalk.learn.train.finals import Finals


class Examined:
    """The run folder of such a run, as `jaxwalk train` leaves it but for what it is resumed from.

    Attributes:
      footsteps: made so far. best_footsteps: when the best policy was handed out.
    """

    def __init__(
        self, config: Config, mesh: Mesh, seed: int, folder: RunFolder, progress: Progress, stop: Stop
    ) -> None:
        self._config, self._folder, self._progress, self._stop = config, folder, progress, stop
        self._exam = Exam(config, policy.act, mesh, seed)
        self._finals = Finals(config, mesh, seed)
        self._started = time.perf_counter()
        self._found: dict[int, Marks] = {}
        self._rows: list[dict[str, float]] = []
        self.footsteps = self.best_footsteps = 0

    def report(self, handed: Policy, told: Mapping[str, float]) -> bool:
        """Examine ``handed`` and keep it; as the best one if it is. Whether the user wants an end.

        Args:
          told: more for its row of metrics.
        """
        self.footsteps = footsteps = handed.metadata.footsteps
        marks, _ = self._exam(policy.without_origin(handed))
        finite = math.isfinite(marks.score)
        scored = dataclasses.replace(handed.metadata, score=marks.score if finite else None)
        kept = dataclasses.replace(handed, metadata=scored)
        row = {"footsteps": footsteps, "seconds": self._seconds(), **told}
        row |= {f"eval/{name}": value for name, value in dataclasses.asdict(marks).items()}
        self._rows.append(row)
        self._folder.log(row)
        self._progress.update(footsteps, row)
        policy.save(kept, self._folder.candidate(footsteps))
        better = finite and (not self._found or marks.score > self._found[self.best_footsteps].score)
        if better:
            self.best_footsteps = footsteps
            policy.save(kept, self._folder.policy)
        if finite:
            self._found[footsteps] = marks
        self._finals.enter(kept, marks.score)
        with figures.spare(self._progress.note):
            picture.training_png(self._rows, self._folder.picture)
        self._progress.note(
            f"evaluation at {footsteps:,} footsteps: {marks.survival:.0%} of the pushed walk on, "
            f"{marks.calm:.0%} of the others stay up, {marks.speed:.2f} m/s"
            + ("; best so far" if better else "")
        )
        return self._stop.wanted

    def finish(self, told: Mapping[str, Any]) -> None:
        """Settle which policy is kept, and write the summary, with what is ``told`` of the learner."""
        settled = [] if self._stop.wanted or not self._found else self._finals.settle()
        if settled:
            self.best_footsteps = settled[0][0].metadata.footsteps
            policy.save(settled[0][0], self._folder.policy)
        best = self._found.get(self.best_footsteps)
        finals = [
            {"footsteps": one.metadata.footsteps, **dataclasses.asdict(marks)} for one, marks in settled
        ]
        self._folder.write_summary(
            {
                "interrupted": self._stop.wanted,
                "footsteps": self.footsteps,
                "seconds": self._seconds(),
                **told,
                "best": best and {"footsteps": self.best_footsteps, **dataclasses.asdict(best)},
                "finals": finals,
            }
        )
        self._progress.note(f"best policy (at {self.best_footsteps:,} footsteps) in {self._folder.policy}")

    def _seconds(self) -> float:
        return time.perf_counter() - self._started
