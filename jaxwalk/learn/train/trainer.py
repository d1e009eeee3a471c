"""One training on its way: reports, evaluations, checkpoints, ways back out of divergence, its end."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Generator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import jax
import numpy as np
from jax.sharding import Mesh

from jaxwalk.common import figures
from jaxwalk.common.errors import Agreed
from jaxwalk.common.interrupt import Stop
from jaxwalk.common.parallel import collectives, devices
from jaxwalk.config import Config
from jaxwalk.learn.ddpg import learner
from jaxwalk.learn.ddpg.learner import LearnerState
from jaxwalk.learn.policies import policy
from jaxwalk.learn.policies.policy import Policy
from jaxwalk.learn.runs import picture
from jaxwalk.learn.runs.progress import Progress
from jaxwalk.learn.runs.run_folder import RunFolder
from jaxwalk.learn.train import checkpoint, device_loop, evaluation, restore
from jaxwalk.learn.train.checkpoint import Checkpoint, Store
from jaxwalk.learn.train.evaluation import Marks
from jaxwalk.learn.train.finals import Finals
from jaxwalk.learn.train.run_state import Past, Record

DRAW_SECONDS = 30.0
"""Least time between two drawings of training.png, each of which takes a second."""
Watch = Callable[[int, Marks], bool]
"""Sees (footsteps, what was found) after each evaluation; true ends the run as Ctrl-C would."""


@dataclass(frozen=True)
class Assess:
    """A run asks for the `Marks` of its averaged learner."""

    learner: LearnerState


@dataclass(frozen=True)
class Advance:
    """A run asks for its state a report's windows further, and for the seconds that took."""


@dataclass(frozen=True)
class Settle:
    """A run asks for the `Marks` of its finalists; None: it has been interrupted, and ends without."""

    finalists: list[Policy]


Asked = Assess | Advance | Settle


class Training:
    """A run in its folder. `go` leads it; who leads several runs at once answers what their `course` asks.

    Attributes:
      state: of the loop. advance: a report's windows further.
      exam: of the averaged learner. returns: what its critic believes, beside what came.
      rows: of metrics.jsonl. record: what the evaluations found.
      good: where training goes back to when it diverges.
    """

    def __init__(
        self,
        config: Config,
        folder: RunFolder,
        identity: str,
        seed: int,
        command: str,
        mesh: Mesh,
        progress: Progress,
        stop: Stop,
    ) -> None:
        self.config, self.folder, self.seed, self.command, self.mesh = config, folder, seed, command, mesh
        self.progress, self.stop, self.identity = progress, stop, identity
        self.started = time.perf_counter()
        self.state = device_loop.init(config, mesh, seed)
        self.advance: Any = device_loop.make(config, mesh)
        self.exam = evaluation.of_learner(config, mesh, seed)
        self.returns = device_loop.returns(config, mesh)
        self.finals = Finals(config, mesh, seed)
        self.record = Record()
        self.rows: list[dict[str, Any]] = []
        self.good: Checkpoint | None = None  # where training goes back to when it diverges
        self.store: Store | None = None
        if config.train.checkpoint_seconds > 0:
            self.store = self._open_store()
        self.watch: Watch = lambda *_: False
        self.saved = self.drawn = float("-inf")  # when; by the clock that never jumps

    def _open_store(self) -> Store:
        return Store(self.folder.resume, self.identity)

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
        found = restore.latest(self.config, self.mesh, self.folder, self.store, self.progress.note)
        if found is None:
            self.progress.note("no checkpoint yet: the run begins anew")
            return
        self.state, self.good, self.record, self.rows = found.state, found.good, found.record, found.rows
        for learned, score in found.finalists:
            self.finals.enter(learned, score)
        self.progress.note(f"resumed at {int(self.state.footsteps):,} footsteps")

    def _snapshot(self) -> Checkpoint:
        """All of the run as it is now, but for where it would go back to."""
        notes = Past(len(self.rows), self.record, self.finals.entered).to_notes()
        notes["record"]["seconds"] = self._seconds()
        return Checkpoint(checkpoint.pack(self.state), notes)

    def save(self, now: Checkpoint | None = None, wait: bool = False) -> None:
        """Begin a checkpoint of ``now``, default the run as it is; ``wait``: until it is on disk."""
        if self.store is None:
            return
        now = now or self._snapshot()
        self.folder.sync()  # no checkpoint knows of a row that a loss of power takes
        self.store.save(checkpoint.of_run(now, self.good or now), wait)
        self.saved = time.perf_counter()

    def save_if_due(self) -> None:
        """Begin a checkpoint, ``checkpoint_seconds`` after the last one, unless one is being written."""
        if self.config.train.checkpoint_seconds <= 0 or self.store is None:
            return
        due = time.perf_counter() - self.saved >= self.config.train.checkpoint_seconds
        busy, due = collectives.any_process(self.store.busy(), due)
        if due and not busy:
            # The first is waited for: without it, a kill in the first report would leave nothing.
            self.save(wait=self.saved == float("-inf"))

    def _seconds(self) -> float:
        return self.record.seconds + time.perf_counter() - self.started

    def go(self) -> None:
        """Lead the run to its end."""
        if collectives.count() > 1:  # as in `device_loop.init`
            self.advance = self.advance.lower(self.state).compile()
            collectives.barrier()
        course, answer = self.course(), None
        with contextlib.suppress(StopIteration):
            while True:
                answer = self._answer(course.send(answer))

    def _answer(self, asked: Asked) -> Any:
        if isinstance(asked, Assess):
            return self.exam(asked.learner)[0]
        if isinstance(asked, Settle):
            return self.finals.examine(asked.finalists)
        begun = time.perf_counter()
        self.state = jax.block_until_ready(self.advance(self.state))
        return time.perf_counter() - begun

    def course(self) -> Generator[Asked, Any, None]:
        """Report, evaluate and save until all footsteps are made or somebody ends it; then settle which
        policy is kept, write the summary, and draw and tell how it ended.

        It asks for what is computed, and is sent that.

        Raises:
          UserError: training diverged, no evaluation came to a finite score, or a disk is full.
        """
        total = self.config.train.footsteps
        while True:
            footsteps = int(self.state.footsteps)
            if self._evaluation_due(footsteps) and not (self.rows and self._stop_wanted()):
                current = devices.here(learner.averaged(self.state.learner), self.mesh)
                self._evaluated(footsteps, current, (yield Assess(current)))
            interrupted = self._stop_wanted()
            if footsteps >= total or interrupted:
                break
            self.save_if_due()
            seconds = yield Advance()
            if len(self.rows) == 1:
                self.record.compile_seconds += seconds
            self.report(int(self.state.footsteps), jax.device_get(self.state.counts), seconds)
        if self.config.train.checkpoint_seconds > 0:
            self.save(wait=interrupted)
        if not self.record.found:
            raise Agreed(
                f"no evaluation of the run in {self.folder.path} came to a finite score: no policy "
                "is kept; begin a run with other --physics, --gait or --body options"
            )
        # Who interrupts wants to end: the best by the evaluations stands.
        marks = []
        if not interrupted and (finalists := self.finals.finalists):
            self.progress.note("the best policies meet more pushes")
            marks = yield Settle(finalists)
        interrupted = interrupted or marks is None
        self._finish(footsteps, interrupted, self._settle(marks or []))

    def _stop_wanted(self) -> bool:
        """Whether any of the processes was told to stop: so all do."""
        return collectives.any_process(self.stop.wanted)[0]

    def _evaluation_due(self, footsteps: int) -> bool:
        """Whether one of the evaluations, the first at 0, has come due since the latest."""
        train = self.config.train
        due = (train.footsteps * i / train.evaluations for i in range(train.evaluations + 1))
        return any(self.record.evaluated < one <= footsteps for one in due)

    def report(self, footsteps: int, counts: device_loop.Counts, seconds: float) -> None:
        """Log and show what ``counts`` say of the last ``seconds`` s; go back if training has diverged."""
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
        state = checkpoint.unpack(
            good.arrays, device_loop.layout(self.config), device_loop.shardings(self.mesh)
        )
        # Other draws from here on, or all would come as before.
        self.state = state.replace(key=jax.random.fold_in(state.key, len(self.record.divergences)))
        self.good = self._snapshot()
        self.progress.note(
            f"{since} updates since {back_to:,} footsteps were not finite: training goes back to there"
        )

    def _give_up(self, good: Checkpoint, footsteps: int) -> None:
        path = self.folder.path
        self.store = self.store or self._open_store()
        self.save(good, wait=True)
        self._write_summary(footsteps, interrupted=True, finals=[])
        raise Agreed(
            f"training diverged at {footsteps:,} footsteps, time {len(self.record.divergences)}: begin a run "
            f"with a lower --ddpg.critic-lr or --ddpg.actor-lr; jaxwalk train --resume {path} shows it again"
        )

    def _evaluated(self, footsteps: int, current: LearnerState, found: Marks) -> None:
        """Keep the policy of the averaged learner, in which so much was found; as the best one if it is."""
        record = self.record
        if not self.rows:
            record.compile_seconds += time.perf_counter() - self.started
        predicted, came = (float(x) for x in self.returns(self.state))
        row = {"footsteps": footsteps, "seconds": self._seconds()}
        row |= {"train/predicted_return": predicted, "train/real_return": came}
        self._log(row | {f"eval/{name}": value for name, value in asdict(found).items()})
        learned = policy.from_learner(
            self.config, current, seed=self.seed, command=self.command, footsteps=footsteps, score=found.score
        )
        if self.folder.writes:
            policy.write(learned, self.folder.candidate(footsteps))
        better = np.isfinite(found.score) and (
            not record.found or found.score > record.found[record.best].score
        )
        if better:
            record.best = footsteps
            if self.folder.writes:
                policy.write(learned, self.folder.policy)
        self.finals.enter(learned, found.score)
        if np.isfinite(found.score):
            record.found[footsteps] = found
        record.last, record.evaluated = found, footsteps
        self.good = self._snapshot()
        if time.perf_counter() > self.drawn + DRAW_SECONDS:
            self._draw()
        self.progress.note(
            f"evaluation at {footsteps:,} footsteps: {found.survival:.0%} of the pushed walk on, "
            f"{found.calm:.0%} of the others stay up, {found.speed:.2f} m/s"
            + (f", return {predicted:.1f} predicted, {came:.1f} came" if np.isfinite(came) else "")
            + ("; best so far" if better else "")
        )
        if self.watch(footsteps, found):
            self.stop.wanted = True

    def _draw(self) -> None:
        if self.folder.writes:
            with figures.spare(self.progress.note):
                picture.training_png(self.rows, self.folder.picture)
        self.drawn = time.perf_counter()

    def _settle(self, marks: Sequence[Marks]) -> list[dict[str, Any]]:
        """Keep the winner of the finals; gives the finalists' marks, the winner's first."""
        settled = self.finals.settled(marks)
        if not settled:
            return []
        winner = settled[0][0]
        self.record.best = winner.metadata.footsteps
        if self.folder.writes:
            policy.write(winner, self.folder.policy)
        return [{"footsteps": one.metadata.footsteps, **asdict(found)} for one, found in settled]

    def _finish(self, footsteps: int, interrupted: bool, finals: list[dict[str, Any]]) -> None:
        self._write_summary(footsteps, interrupted, finals)
        if self.store is not None and not interrupted:
            self.store.clear()
        self._draw()
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
