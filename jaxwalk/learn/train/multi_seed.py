"""Several seeds at once: independent trainings in the lanes of one program, each with its own run folder."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import jax
import numpy as np

from jaxwalk.common.errors import UserError
from jaxwalk.common.parallel import devices
from jaxwalk.config import Config
from jaxwalk.learn.ddpg import learner
from jaxwalk.learn.policies import policy
from jaxwalk.learn.runs import run_folder, seeds_folder
from jaxwalk.learn.runs.progress import Progress
from jaxwalk.learn.runs.run_folder import RunFolder
from jaxwalk.learn.train import lanes, out_of_resources, seeds_summary
from jaxwalk.learn.train.device_loop import Counts
from jaxwalk.learn.train.evaluation import Assessor, Marks
from jaxwalk.learn.train.interrupt import Stop
from jaxwalk.learn.train.lane_evaluation import Exams
from jaxwalk.learn.train.lanes import Lanes
from jaxwalk.learn.train.trainer import Training
from jaxwalk.task import collect

_RATE = "train/footsteps_per_second"


def run_many(config: Config, run_dir: Path | None, first: int, count: int, command: str) -> Path:
    """Train seeds ``first`` to ``first + count - 1``, and return the folder that holds their run folders.

    Each is trained as ``run`` does it on one device. Ctrl-C (or SIGTERM) ends all after the report
    under way. A seed that fails ends alone.

    Raises:
      UserError: as for ``run``; or every seed failed.
    """
    collect.check(config)
    every = range(first, first + count)
    parent = seeds_folder.create(run_dir, config, every, command)
    with contextlib.ExitStack() as stack:
        folders = {
            seed: stack.enter_context(
                RunFolder.create(seeds_folder.folder(parent, seed), config, seed, command)
            )
            for seed in every
        }
        _train(config, parent, folders, command, resumed=False)
    return parent


def resume_many(parent: Path) -> Path:
    """Go on with those of the runs in ``parent`` that are not finished, as ``resume`` does with one.

    Raises:
      UserError: as for ``resume``, of any of them.
    """
    paths = {seed: seeds_folder.folder(parent, seed) for seed in seeds_folder.load(parent)}
    summaries = {seed: run_folder.read_summary(path) for seed, path in paths.items()}
    left = {seed: path for seed, path in paths.items() if summaries[seed].get("interrupted", True)}
    if not left:
        raise UserError(f"the run in {parent} is finished: nothing is left to resume")
    first = next(iter(left.values()))
    config, origin = run_folder.load_config(first), run_folder.load_origin(first)
    run_folder.say_what_changed(origin.versions, config)
    with contextlib.ExitStack() as stack:
        folders = {seed: stack.enter_context(RunFolder.reopen(path)) for seed, path in left.items()}
        _train(config, parent, folders, origin.command, resumed=True)
    return parent


def _train(
    config: Config, parent: Path, folders: Mapping[int, RunFolder], command: str, resumed: bool
) -> None:
    where = f"devices ({jax.devices()[0].platform}): {lanes.mesh(len(folders)).size}"
    print(f"run folder {parent}, seeds {', '.join(map(str, folders))}, {where}", flush=True)
    with contextlib.ExitStack() as stack:
        stack.enter_context(out_of_resources.explained(config, parent))
        progress = stack.enter_context(Progress(len(folders) * config.train.footsteps))
        stop = stack.enter_context(Stop())
        trainings = []
        for seed, folder in folders.items():
            voice = _Voice(progress, seed)
            one = Training(
                config, folder, run_folder.identity(folder.path), seed, command, devices.mesh(1), voice, stop
            )
            stack.enter_context(contextlib.closing(one))
            trainings.append(_Seed(one, voice, Assessor(config, devices.mesh(1), seed)))
            if resumed:
                one.restore()
        _Many(config, trainings, progress, stop).go()
    failed = {one.run.seed: one.failed for one in trainings if one.failed}
    seeds_summary.conclude(parent, {seed: str(error) for seed, error in failed.items()})
    if len(failed) == len(folders):
        raise next(iter(failed.values()))


class _Voice(Progress):
    """What one seed tells of itself: its notes by its number, its latest report for all at once."""

    def __init__(self, shared: Progress, seed: int) -> None:
        self._shared, self._seed = shared, seed
        self.row: Mapping[str, float | int] = {}

    def update(self, footsteps: int, metrics: Mapping[str, float | int]) -> None:
        self.row = metrics

    def note(self, text: str) -> None:
        self._shared.note(f"seed {self._seed}: {text}")


@dataclass
class _Seed:
    """One of the trainings.

    Attributes:
      run: as it would be alone, but that others advance and examine it.
      voice: what it tells.
      assessor: judges its examinations.
      failed: why it ended before its time.
    """

    run: Training
    voice: _Voice
    assessor: Assessor
    failed: UserError | None = None

    @property
    def footsteps(self) -> int:
        return int(self.run.state.footsteps)

    def report(self, counts: Counts, seconds: float) -> None:
        self.run.report(self.footsteps, counts, seconds)

    @contextlib.contextmanager
    def alone(self) -> Iterator[None]:
        """Within it, what fails ends this seed's training, and no other's."""
        try:
            yield
        except UserError as error:
            self.failed = error
            self.voice.note(str(error))


class _Many:
    def __init__(self, config: Config, trainings: Sequence[_Seed], progress: Progress, stop: Stop) -> None:
        self.config, self.seeds, self.progress, self.stop = config, trainings, progress, stop
        self.mesh = lanes.mesh(len(trainings))
        self.lanes = Lanes(config, [one.run.state for one in trainings], self.mesh)
        self.exams = Exams(config, [one.assessor.exam for one in trainings], self.mesh)

    def go(self) -> None:
        total = self.config.train.footsteps
        while True:
            self._evaluate()
            live = [not one.failed and one.footsteps < total for one in self.seeds]
            if self.stop.wanted or not any(live):
                break
            for one in self._those(live):
                with one.alone():
                    one.run.save_if_due()
            self._advance(live)
        self._finish()

    def _those(self, wanted: Sequence[bool]) -> list[_Seed]:
        return [one for one, is_wanted in zip(self.seeds, wanted, strict=True) if is_wanted]

    def _evaluate(self) -> None:
        """Evaluate, all at once, the seeds whose turn has come."""
        due = [
            not one.failed
            and one.run.evaluation_due(one.footsteps)
            and not (one.run.rows and self.stop.wanted)
            for one in self.seeds
        ]
        if not any(due):
            return
        learners = [learner.averaged(one.run.state.learner) for one in self.seeds]
        found = self.exams(learners, due)
        for one, is_due, examined in zip(self.seeds, due, found, strict=True):
            if is_due:
                judge = one.assessor.judge
                one.run.assess = lambda state, judge=judge, examined=examined: judge(state, *examined)
                with one.alone():
                    one.run.evaluate(one.footsteps)

    def _advance(self, live: Sequence[bool]) -> None:
        begun = time.perf_counter()
        self.lanes.advance(live)
        taken = {lane: self.lanes.take(lane) for lane, is_live in enumerate(live) if is_live}
        jax.block_until_ready(taken)
        seconds = time.perf_counter() - begun
        for lane, state in taken.items():
            one = self.seeds[lane]
            one.run.state = state
            if len(one.run.rows) == 1:
                one.run.record.compile_seconds += seconds
            with one.alone():
                one.report(jax.device_get(state.counts), seconds)
            if one.run.state is not state:  # it went back
                self.lanes.put(lane, one.run.state)
        rows = [one.voice.row for one in self._those(live)]
        self.progress.update(sum(one.footsteps for one in self.seeds), _together(rows))

    def _finish(self) -> None:
        interrupted = self.stop.wanted  # asked once: what comes later finds all of them finished
        if self.config.train.checkpoint_seconds > 0:
            for one in self._standing():
                with one.alone():
                    one.run.save(wait=interrupted)
        if not interrupted:
            self._examine_finalists()
        for one in self._standing():
            with one.alone():
                one.run.finish(one.footsteps, interrupted)

    def _standing(self) -> list[_Seed]:
        return [one for one in self.seeds if not one.failed]

    def _examine_finalists(self) -> None:
        """The first ones of all seeds at once, then the second ones, and so on, for `Finals.settle`."""
        finalists = [[] if one.failed else one.run.finals.finalists for one in self.seeds]
        rounds = max(map(len, finalists))
        if not rounds:
            return
        self.progress.note("the best policies of each seed meet more pushes")
        exams = Exams(self.config, [one.run.finals.exam() for one in self.seeds], self.mesh)
        marks: list[list[Marks]] = [[] for _ in self.seeds]
        spare = next(policies[0] for policies in finalists if policies)
        for turn in range(rounds):
            live = [turn < len(policies) for policies in finalists]
            there = [
                policies[turn] if is_live else spare
                for policies, is_live in zip(finalists, live, strict=True)
            ]
            found = exams([policy.without_origin(one) for one in there], live)
            for lane, (mark, _) in enumerate(found):
                if live[lane]:
                    marks[lane].append(mark)
        for one, own in zip(self.seeds, marks, strict=True):
            one.run.finals.examine = lambda _, own=own: own


def _together(rows: Sequence[Mapping[str, float | int]]) -> dict[str, float]:
    """Means over the seeds, but for the footsteps a second, which add up."""
    names = set.intersection(*(set(row) for row in rows))
    found = {name: float(np.mean([row[name] for row in rows])) for name in names}
    return found | {_RATE: found[_RATE] * len(rows)} if _RATE in found else found
