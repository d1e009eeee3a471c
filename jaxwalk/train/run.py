"""A training run, from the command's point of view: progress, metrics, the best policy, the end."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import jax
import numpy as np
from jax.sharding import Mesh

from jaxwalk import devices, files, plots, policy, run_folder, runtime, windows
from jaxwalk.config import Config
from jaxwalk.ddpg import learner
from jaxwalk.ddpg.learner import LearnerState
from jaxwalk.errors import UserError
from jaxwalk.policy import Policy
from jaxwalk.progress import Progress
from jaxwalk.run_folder import RunFolder
from jaxwalk.train import checkpoint, loop
from jaxwalk.train.assess import Assessment, Assessor
from jaxwalk.train.checkpoint import Checkpoint, Store
from jaxwalk.train.finals import Finals
from jaxwalk.train.record import Past, Record
from jaxwalk.train.stop import Stop

Watch = Callable[[int, Assessment], bool]
"""Sees (footsteps, what was found) after each evaluation; true ends the run as Ctrl-C would."""


def run(
    config: Config, run_dir: Path | None, seed: int, command: str, watch: Watch = lambda *_: False
) -> Path:
    """Train, and return the run folder.

    Ctrl-C (or SIGTERM) ends after the report under way and keeps the best policy so far.

    Raises:
      UserError: a configuration that cannot be run, a folder that cannot be used, a disk or a memory
        that is full, or a training that diverges again and again.
    """
    windows.check(config)
    mesh = devices.mesh(config.train.walkers)
    with RunFolder.create(run_dir, config, seed, command) as folder:
        _train(config, folder, seed, command, mesh, resumed=False, watch=watch)
        return folder.path


def resume(path: Path) -> Path:
    """Go on with the run in ``path`` from its latest checkpoint, and return the folder.

    On the same machine and versions, all comes bit for bit as if the run had never been stopped.

    Raises:
      UserError: as for ``run``; or there is no run, it is finished, it has no usable checkpoint, it was
        laid out for another number of devices, or another process trains it.
    """
    origin = run_folder.load_origin(path)
    config = run_folder.load_config(path)
    mesh = devices.mesh(config.train.walkers)
    with RunFolder.reopen(path) as folder:
        summary = run_folder.read_summary(path)
        if summary and not summary.get("interrupted"):
            raise UserError(f"the run in {path} is finished: nothing is left to resume")
        _say_what_changed(origin.versions)
        _train(config, folder, origin.seed, origin.command, mesh, resumed=True)
        return folder.path


def _train(
    config: Config,
    folder: RunFolder,
    seed: int,
    command: str,
    mesh: Mesh,
    resumed: bool,
    watch: Watch = lambda *_: False,
) -> None:
    print(f"run folder {folder.path}, devices ({jax.devices()[0].platform}): {mesh.size}", flush=True)
    with (
        _one_line_errors(config, folder.path),
        Progress(config.train.footsteps) as progress,
        Stop() as stop,
        contextlib.closing(_Run(config, folder, seed, command, mesh, progress, stop)) as training,
    ):
        training.watch = watch
        if resumed:
            training.restore()
        training.go()


def _say_what_changed(versions: Mapping[str, str]) -> None:
    now = runtime.versions()["versions"]
    other = [f"{name} {old} (now {now.get(name)})" for name, old in versions.items() if now.get(name) != old]
    if other:
        print(f"begun with {', '.join(other)}: goes on, but perhaps not bit for bit", flush=True)


@contextlib.contextmanager
def _one_line_errors(config: Config, path: Path) -> Iterator[None]:
    """What the machine has too little of, as one line."""
    try:
        yield
    except BrokenPipeError:  # nobody reads what is told any more
        raise
    except OSError as error:
        raise UserError(
            f"cannot write into {path}: {error.strerror or error}; make room there, then go on with "
            f"jaxwalk train --resume {path}"
        ) from error
    except (MemoryError, jax.errors.JaxRuntimeError) as error:
        if isinstance(error, jax.errors.JaxRuntimeError) and "RESOURCE_EXHAUSTED" not in str(error):
            raise
        raise UserError(
            f"out of memory: begin a run with less than --train.walkers {config.train.walkers} or "
            f"--ddpg.replay-capacity {config.ddpg.replay_capacity}"
        ) from error


class _Run:
    def __init__(
        self,
        config: Config,
        folder: RunFolder,
        seed: int,
        command: str,
        mesh: Mesh,
        progress: Progress,
        stop: Stop,
    ) -> None:
        self.config, self.folder, self.seed, self.command, self.mesh = config, folder, seed, command, mesh
        self.progress, self.stop = progress, stop
        self.started = time.perf_counter()
        self.state = loop.init(config, mesh, seed)
        self.advance = loop.make(config, mesh)
        self.assess: Callable[[LearnerState], Assessment] = Assessor(config, mesh, seed)
        self.finals = Finals(config, mesh, seed)
        self.record = Record()
        self.rows: list[dict[str, Any]] = []
        self.good: Checkpoint | None = None  # where training goes back to when it diverges
        self.store: Store | None = None
        if config.train.checkpoint_seconds > 0:
            self.store = self._open_store()
        self.watch: Watch = lambda *_: False
        self.saved = float("-inf")  # when; by the clock that never jumps

    def _open_store(self) -> Store:
        return Store(self.folder.resume, run_folder.identity(self.folder.path))

    def close(self) -> None:
        """Let the checkpoint under way be written."""
        if self.store is not None:
            self.store.close()

    def restore(self) -> None:
        """Take everything from the latest checkpoint.

        Raises:
          UserError: as for ``resume``.
        """
        self.store = self.store or self._open_store()
        like = loop.layout(self.config, self.mesh)
        found = self.store.latest(self.progress.note, 2 * checkpoint.size(like))
        path = self.folder.path
        if found is None:
            # Killed before the first checkpoint, which follows the first evaluation at once.
            if len(run_folder.read_metrics(path)) > 1:
                raise UserError(f"the run in {path} holds no checkpoint to resume from: begin a new run")
            self.folder.keep(0)
            self.progress.note("no checkpoint yet: the run begins anew")
            return
        try:
            devices, now, good = (found.notes[name] for name in ("devices", "now", "good"))
            past, _ = Past.from_notes(now), Past.from_notes(good)
        except (KeyError, TypeError, ValueError, AttributeError):
            raise UserError(
                f"the checkpoint in {self.folder.resume} is of another version of jaxwalk: its notes do not "
                "fit; go on with the version that made it"
            ) from None
        if devices != self.mesh.size:
            raise UserError(
                f"the run in {path} is laid out for {devices!s:.20} devices, not {self.mesh.size}: "
                f"resume it with JAX_NUM_CPU_DEVICES={devices!s:.20} or on as many GPUs"
            )
        self.good = Checkpoint(_under("good.", found.arrays), good)
        checkpoint.check_fits(self.good.arrays, like)
        self.state = self._place(_under("now.", found.arrays))
        finalists = [(self._load(footsteps), score) for footsteps, score in past.finalists]
        self.record = past.record
        if self.record.found:
            self._load(self.record.best)
        self.rows = self.folder.keep(past.rows)
        for learned, score in finalists:
            self.finals.enter(learned, score)
        self._forget_what_came_later()
        self.folder.drop_summary()
        self.progress.note(f"resumed at {int(self.state.footsteps):,} footsteps")

    def _forget_what_came_later(self) -> None:
        """The policies in the folder become those that the record knows."""
        for file in self.folder.checkpoints.glob("*.safetensors"):
            if file.stem.isdecimal() and int(file.stem) > self.record.evaluated:
                file.unlink()
        if self.record.found:
            files.write_bytes(self.folder.policy, self._candidate(self.record.best).read_bytes())

    def _load(self, footsteps: int) -> Policy:
        """The policy of an evaluation.

        Raises:
          UserError: it is gone, damaged, or not of this run's kind.
        """
        file = self._candidate(footsteps)
        found = policy.load(file)
        told = found.metadata
        if (told.hidden, told.observation_names) != (self.config.ddpg.hidden, self.config.observation):
            raise UserError(f"policy {file} is not of the run that it lies in: begin a new run")
        return found

    def _place(self, arrays: dict[str, np.ndarray]) -> loop.TrainState:
        like = loop.layout(self.config, self.mesh)
        return checkpoint.unpack(arrays, like, loop.shardings(self.mesh))

    def _snapshot(self) -> Checkpoint:
        """All of the run as it is now, but for where it would go back to."""
        notes = Past(len(self.rows), self.record, self.finals.entered).to_notes()
        notes["record"]["seconds"] = self._seconds()
        return Checkpoint(checkpoint.pack(self.state), notes)

    def _save(self, now: Checkpoint | None = None, wait: bool = False) -> None:
        if self.store is None:
            return
        now = now or self._snapshot()
        self.folder.sync()  # no checkpoint knows of a row that a loss of power takes
        self.store.save(checkpoint.of_run(now, self.good or now, self.mesh.size), wait)
        self.saved = time.perf_counter()

    def _save_if_due(self) -> None:
        if self.config.train.checkpoint_seconds <= 0 or self.store is None or self.store.busy():
            return
        if time.perf_counter() - self.saved >= self.config.train.checkpoint_seconds:
            # The first is waited for: without it, a kill in the first report would leave nothing.
            self._save(wait=self.saved == float("-inf"))

    def _seconds(self) -> float:
        return self.record.seconds + time.perf_counter() - self.started

    def go(self) -> None:
        total = self.config.train.footsteps
        while True:
            footsteps = int(self.state.footsteps)
            if self._evaluation_due(footsteps) and not (self.rows and self.stop.wanted):
                self._evaluate(footsteps)
            if footsteps >= total or self.stop.wanted:
                break
            self._save_if_due()
            begun = time.perf_counter()
            self.state = self.advance(self.state)
            counts = jax.device_get(self.state.counts)
            seconds = time.perf_counter() - begun
            if len(self.rows) == 1:
                self.record.compile_seconds += seconds
            self._report(int(self.state.footsteps), counts, seconds)
        if self.config.train.checkpoint_seconds > 0:
            self._save(wait=self.stop.wanted)
        self._finish(footsteps)

    def _evaluation_due(self, footsteps: int) -> bool:
        """Whether one of the evaluations, the first at 0, has come due since the latest."""
        train = self.config.train
        due = (train.footsteps * i / train.evaluations for i in range(train.evaluations + 1))
        return any(self.record.evaluated < one <= footsteps for one in due)

    def _report(self, footsteps: int, counts: loop.Counts, seconds: float) -> None:
        steps = max(float(counts.footsteps), 1.0)
        metrics = jax.device_get(self.state.learner.metrics)
        self.record.totals["falls"] += float(counts.falls)
        self.record.totals["broken"] += float(counts.broken)
        row = {
            "footsteps": footsteps,
            "seconds": self._seconds(),
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
        if last := self.record.last:
            row |= {"train/predicted_return": last.predicted, "train/real_return": last.real}
        self._log(row)
        self.progress.update(footsteps, row)
        self._go_back_if_diverged(footsteps, int(metrics.skipped))

    def _log(self, row: dict[str, Any]) -> None:
        self.rows.append(row)
        self.folder.log(row)

    def _go_back_if_diverged(self, footsteps: int, skipped: int) -> None:
        """Too many updates were skipped since the latest evaluation: train on from there, otherwise.

        Raises:
          UserError: for the last time that is allowed. What is saved then comes to it again.
        """
        good, train = self.good, self.config.train
        if good is None:
            return
        since = skipped - int(good.arrays["learner.metrics.skipped"])
        if since <= train.divergence_limit:
            return
        back_to = int(good.arrays["footsteps"])
        self.record.divergences.append({"footsteps": footsteps, "back_to": back_to, "skipped": since})
        self._log(
            {
                "footsteps": footsteps,
                "seconds": self._seconds(),
                "divergence/back_to": back_to,
                "divergence/skipped": since,
            }
        )
        if len(self.record.divergences) >= train.divergence_events:
            self._give_up(good, footsteps)
        state = self._place(dict(good.arrays))
        # Other draws from here on, or all would come as before.
        self.state = state.replace(key=jax.random.fold_in(state.key, len(self.record.divergences)))
        self.good = self._snapshot()
        self.progress.note(
            f"{since} updates since {back_to:,} footsteps were not finite: training goes back to there"
        )

    def _give_up(self, good: Checkpoint, footsteps: int) -> None:
        path = self.folder.path
        self.store = self.store or self._open_store()
        self._save(good, wait=True)
        self._write_summary(footsteps, interrupted=True, finals=[])
        raise UserError(
            f"training diverged at {footsteps:,} footsteps, time {len(self.record.divergences)}: begin a run "
            f"with a lower --ddpg.critic-lr or --ddpg.actor-lr; jaxwalk train --resume {path} shows it again"
        )

    def _evaluate(self, footsteps: int) -> None:
        found = self.assess(learner.averaged(self.state.learner))
        record = self.record
        if not self.rows:
            record.compile_seconds += time.perf_counter() - self.started
        row = {"footsteps": footsteps, "seconds": self._seconds()}
        self._log(row | {f"eval/{name}": value for name, value in asdict(found).items()})
        learned = self._policy(footsteps, found.score)
        policy.save(learned, self._candidate(footsteps))
        better = np.isfinite(found.score) and (
            not record.found or found.score > record.found[record.best].score
        )
        if better:
            record.best = footsteps
            policy.save(learned, self.folder.policy)
        self.finals.enter(learned, found.score)
        if np.isfinite(found.score):
            record.found[footsteps] = found
        record.last, record.evaluated = found, footsteps
        self.good = self._snapshot()
        plots.training_png(self.rows, self.folder.picture)
        self.progress.note(
            f"evaluation at {footsteps:,} footsteps: {found.survival:.0%} of the pushed and {found.calm:.0%} "
            f"of the others stay up, {found.speed:.2f} m/s, predicted return {found.predicted:.1f} came "
            f"as {found.real:.1f}" + ("; best so far" if better else "")
        )
        if self.watch(footsteps, found):
            self.stop.wanted = True

    def _candidate(self, footsteps: int) -> Path:
        """Where the policy of an evaluation is kept."""
        return self.folder.checkpoints / f"{footsteps:09d}.safetensors"

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
        if self.config.train.finalists > 1:
            self.progress.note("the best policies meet more pushes")
        settled = self.finals.settle()
        if not settled:
            return []
        winner = settled[0][0]
        self.record.best = winner.metadata.footsteps
        policy.save(winner, self.folder.policy)
        return [{"footsteps": one.metadata.footsteps, **asdict(marks)} for one, marks in settled]

    def _finish(self, footsteps: int) -> None:
        interrupted = self.stop.wanted
        if not self.record.found:
            raise UserError(
                f"no evaluation of the run in {self.folder.path} came to a finite score: no policy "
                "is kept; begin a run with other --physics, --gait or --body options"
            )
        # Who interrupts wants to end: the best by the evaluations stands.
        finals = [] if interrupted else self._settle()
        self._write_summary(footsteps, interrupted, finals)
        if self.store is not None and not interrupted:
            self.store.clear()
        plots.training_png(self.rows, self.folder.picture)
        verb = "stopped early" if interrupted else "done"
        self.progress.note(f"{verb}: best policy (at {self.record.best:,} footsteps) in {self.folder.policy}")

    def _write_summary(self, footsteps: int, interrupted: bool, finals: list[dict[str, Any]]) -> None:
        best = self.record.best
        self.folder.write_summary(
            {
                "interrupted": interrupted,
                "footsteps": footsteps,
                "seconds": self._seconds(),
                "first_report_seconds": self.record.compile_seconds,
                "updates": int(self.state.learner.updates),
                **self.record.totals,
                "divergences": self.record.divergences,
                "best": {"footsteps": best, **asdict(self.record.found[best])},
                "finals": finals,
            }
        )


def _under(prefix: str, arrays: Any) -> dict[str, np.ndarray]:
    return {name.removeprefix(prefix): x for name, x in arrays.items() if name.startswith(prefix)}
