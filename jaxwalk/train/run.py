"""A training run, from the command's point of view: progress, metrics, the best policy, the end."""

from __future__ import annotations

import signal
import sys
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

import jax
import numpy as np

from jaxwalk import devices, plots, policy, windows
from jaxwalk.config import Config
from jaxwalk.ddpg import learner
from jaxwalk.policy import Policy
from jaxwalk.progress import Progress
from jaxwalk.run_folder import RunFolder
from jaxwalk.train import loop
from jaxwalk.train.assess import Assessment, Assessor
from jaxwalk.train.finals import Finals


def run(config: Config, run_dir: Path | None, seed: int, command: str) -> Path:
    """Train, and return the run folder.

    Ctrl-C (or SIGTERM) ends after the report under way and keeps the best policy so far.

    Raises:
      UserError: a configuration that cannot be run, or a folder that cannot be used.
    """
    windows.check(config)
    mesh = devices.mesh(config.train.walkers)
    with RunFolder.create(run_dir, config, seed, command) as folder:
        kind = jax.devices()[0].platform
        print(f"run folder {folder.path}, devices ({kind}): {mesh.size}", flush=True)
        with Progress(config.train.footsteps) as progress, Stop() as stop:
            _Run(config, folder, seed, command, mesh, progress, stop).go()
        return folder.path


class Stop:
    """Turns the first Ctrl-C or SIGTERM into a wish; the second interrupts as usual."""

    def __enter__(self) -> Stop:
        self.wanted = False
        self._old = {s: signal.signal(s, self._wish) for s in (signal.SIGINT, signal.SIGTERM)}
        return self

    def _wish(self, number: int, frame: Any) -> None:
        self.wanted = True
        print("stopping after the report under way; Ctrl-C again ends at once", file=sys.stderr, flush=True)
        for which, old in self._old.items():
            signal.signal(which, old)

    def __exit__(self, *_: object) -> None:
        for which, old in self._old.items():
            signal.signal(which, old)


class _Run:
    def __init__(
        self,
        config: Config,
        folder: RunFolder,
        seed: int,
        command: str,
        mesh: Any,
        progress: Progress,
        stop: Stop,
    ) -> None:
        self.config, self.folder, self.seed, self.command = config, folder, seed, command
        self.progress, self.stop = progress, stop
        self.state = loop.init(config, mesh, seed)
        self.advance = loop.make(config, mesh)
        self.assess = Assessor(config, mesh, seed)
        self.finals = Finals(config, mesh, seed)
        self.found: dict[int, Assessment] = {}
        self.best_footsteps = 0
        self.rows: list[dict[str, float]] = []
        self.totals = {"falls": 0.0, "broken": 0.0}
        self.started = time.perf_counter()
        self.compile_seconds = 0.0

    def go(self) -> None:
        train = self.config.train
        due = [train.footsteps * (i + 1) / train.evaluations for i in range(train.evaluations)]
        footsteps = 0
        self._evaluate(0)
        while footsteps < train.footsteps and not self.stop.wanted:
            begun = time.perf_counter()
            self.state = self.advance(self.state)
            counts = jax.device_get(self.state.counts)
            seconds = time.perf_counter() - begun
            if len(self.rows) == 1:
                self.compile_seconds += seconds
            footsteps = int(self.state.footsteps)
            self._report(footsteps, counts, seconds)
            if footsteps >= due[0] and not self.stop.wanted:
                while due and footsteps >= due[0]:
                    due.pop(0)
                self._evaluate(footsteps)
                due = due or [float("inf")]
        self._finish(footsteps)

    def _report(self, footsteps: int, counts: loop.Counts, seconds: float) -> None:
        steps = max(float(counts.footsteps), 1.0)
        metrics = jax.device_get(self.state.learner.metrics)
        self.totals["falls"] += float(counts.falls)
        self.totals["broken"] += float(counts.broken)
        row = {
            "footsteps": footsteps,
            "seconds": time.perf_counter() - self.started,
            "train/reward": float(counts.reward) / steps,
            "train/falls_per_100": 100 * float(counts.falls) / steps,
            "train/broken": float(counts.broken),
            "train/speed": float(counts.speed) / steps,
            "train/step_length": float(counts.length) / steps,
            "train/step_duration": float(counts.seconds) / steps,
            "train/footsteps_per_second": float(counts.footsteps) / seconds,
            "learner/updates": int(self.state.learner.updates),
            **{f"learner/{name}": float(value) for name, value in asdict(metrics).items()},
        }
        last = self.assessment
        row |= {"train/predicted_return": last.predicted, "train/real_return": last.real}
        self.rows.append(row)
        self.folder.log(row)
        self.progress.update(footsteps, row)

    def _evaluate(self, footsteps: int) -> None:
        found = self.assess(learner.averaged(self.state.learner))
        self.assessment = found
        if not self.rows:
            self.compile_seconds += time.perf_counter() - self.started
        row = {"footsteps": footsteps, "seconds": time.perf_counter() - self.started}
        row |= {f"eval/{name}": value for name, value in asdict(found).items()}
        self.rows.append(row)
        self.folder.log(row)
        learned = self._policy(footsteps, found.score)
        policy.save(learned, self.folder.checkpoints / f"{footsteps:09d}.safetensors")
        better = np.isfinite(found.score) and (
            not self.found or found.score > self.found[self.best_footsteps].score
        )
        if better:
            self.best_footsteps = footsteps
            policy.save(learned, self.folder.policy)
        self.finals.enter(learned, found.score)
        if np.isfinite(found.score):
            self.found[footsteps] = found
        plots.training_png(self.rows, self.folder.picture)
        self.progress.note(
            f"evaluation at {footsteps:,} footsteps: {found.survival:.0%} of the pushed and {found.calm:.0%} "
            f"of the others stay up, {found.speed:.2f} m/s, predicted return {found.predicted:.1f} came "
            f"as {found.real:.1f}" + ("; best so far" if better else "")
        )

    def _policy(self, footsteps: int, score: float) -> Policy:
        return policy.from_learner(
            self.config,
            learner.averaged(self.state.learner),
            seed=self.seed,
            command=self.command,
            footsteps=footsteps,
            score=score,
        )

    def _settle(self) -> list[dict[str, Any]]:
        """Keep the winner of the finals; gives the finalists' marks, the winner's first."""
        self.progress.note("the best policies meet more pushes")
        settled = self.finals.settle()
        winner = settled[0][0]
        self.best_footsteps = winner.metadata.footsteps
        policy.save(winner, self.folder.policy)
        return [{"footsteps": one.metadata.footsteps, **asdict(marks)} for one, marks in settled]

    def _finish(self, footsteps: int) -> None:
        # Who interrupts wants to end: the best by the evaluations stands.
        finals = [] if self.stop.wanted else self._settle()
        self.folder.write_summary(
            {
                "interrupted": self.stop.wanted,
                "footsteps": footsteps,
                "seconds": time.perf_counter() - self.started,
                "first_report_seconds": self.compile_seconds,
                "updates": int(self.state.learner.updates),
                **self.totals,
                "best": {"footsteps": self.best_footsteps, **asdict(self.found[self.best_footsteps])},
                "finals": finals,
            }
        )
        plots.training_png(self.rows, self.folder.picture)
        verb = "stopped early" if self.stop.wanted else "done"
        self.progress.note(
            f"{verb}: best policy (at {self.best_footsteps:,} footsteps) in {self.folder.policy}"
        )
