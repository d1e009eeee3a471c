"""Several seeds at once: independent trainings in the lanes of one program, each with its own run folder."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jax
import numpy as np

from jaxwalk.common.errors import UserError
from jaxwalk.common.interrupt import Stop
from jaxwalk.common.parallel import devices
from jaxwalk.config import Config
from jaxwalk.learn.policies import policy
from jaxwalk.learn.runs import run_folder, seeds_folder
from jaxwalk.learn.runs.progress import Progress
from jaxwalk.learn.runs.run_folder import RunFolder
from jaxwalk.learn.train import lanes, out_of_resources, seeds_summary
from jaxwalk.learn.train.evaluation import Marks
from jaxwalk.learn.train.lane_evaluation import Exams
from jaxwalk.learn.train.lanes import Lanes
from jaxwalk.learn.train.trainer import Advance, Asked, Assess, Settle, Training
from jaxwalk.task import collect

_RATE = "train/footsteps_per_second"


def run_many(config: Config, run_dir: Path | None, first: int, count: int, command: str) -> Path:
    """Train seeds ``first`` to ``first + count - 1``, and return the folder that holds their run folders.

    Each is trained as ``run`` does it on one device. Ctrl-C (or SIGTERM, SIGHUP) ends all after the report
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
            if resumed:
                one.restore()
            trainings.append(_Seed(one, voice, one.course()))
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
      run: as it would be alone. voice: what it tells.
      course: of the run. asked: what it waits for; None: it has ended.
      failed: why it ended before its time.
    """

    run: Training
    voice: _Voice
    course: Generator[Asked, Any, None]
    asked: Asked | None = None
    failed: UserError | None = None

    def go_on(self, answer: Any = None) -> None:
        """On to what it asks for next. What fails ends this seed's training, and no other's."""
        try:
            self.asked = self.course.send(answer)
        except StopIteration:
            self.asked = None
        except UserError as error:
            self.asked, self.failed = None, error
            self.voice.note(str(error))


class _Many:
    """Answers at once what several trainings ask for."""

    def __init__(self, config: Config, trainings: Sequence[_Seed], progress: Progress, stop: Stop) -> None:
        self.config, self.seeds, self.progress, self.stop = config, trainings, progress, stop
        self.mesh = lanes.mesh(len(trainings))
        self.lanes = Lanes(config, [one.run.state for one in trainings], self.mesh)
        self.exams = Exams(config, [one.run.exam for one in trainings], self.mesh)

    def go(self) -> None:
        for one in self.seeds:
            one.go_on()
        while any(one.asked for one in self.seeds):
            # Whoever has got further waits for the others.
            for kind, answer in ((Assess, self._assess), (Advance, self._advance), (Settle, self._settle)):
                if any(asking := [isinstance(one.asked, kind) for one in self.seeds]):
                    answer(asking)
                    break

    def _asking(self, asking: Sequence[bool]) -> list[_Seed]:
        return [one for one, is_asking in zip(self.seeds, asking, strict=True) if is_asking]

    def _assess(self, asking: Sequence[bool]) -> None:
        learners = [one.asked.learner if isinstance(one.asked, Assess) else None for one in self.seeds]
        spare = next(filter(None, learners))
        found = self.exams([own or spare for own in learners], asking)
        for one, own, examined in zip(self.seeds, learners, found, strict=True):
            if own:
                one.go_on(examined[0])

    def _advance(self, asking: Sequence[bool]) -> None:
        begun = time.perf_counter()
        self.lanes.advance(asking)
        taken = {lane: self.lanes.take(lane) for lane, is_asking in enumerate(asking) if is_asking}
        jax.block_until_ready(taken)
        seconds = time.perf_counter() - begun
        moved = self._asking(asking)
        for lane, state in taken.items():
            one = self.seeds[lane]
            one.run.state = state
            one.go_on(seconds)
            if one.run.state is not state:  # it went back
                self.lanes.put(lane, one.run.state)
        made = sum(int(one.run.state.footsteps) for one in self.seeds)
        self.progress.update(made, _together([one.voice.row for one in moved]))

    def _settle(self, asking: Sequence[bool]) -> None:
        """The first finalists of all seeds meet at once, then the second ones, and so on."""
        finalists = [one.asked.finalists if isinstance(one.asked, Settle) else [] for one in self.seeds]
        exams = Exams(self.config, [one.run.finals.exam() for one in self.seeds], self.mesh)
        marks: list[list[Marks]] = [[] for _ in self.seeds]
        spare = next(policies[0] for policies in finalists if policies)
        for turn in range(0 if self.stop.wanted else max(map(len, finalists))):
            live = [turn < len(policies) for policies in finalists]
            there = [own[turn] if is_live else spare for own, is_live in zip(finalists, live, strict=True)]
            found = exams([policy.without_origin(one) for one in there], live)
            for own, is_live, (mark, _) in zip(marks, live, found, strict=True):
                own.extend([mark] * is_live)
        for one, own in zip(self.seeds, marks, strict=True):
            if isinstance(one.asked, Settle):
                one.go_on(own or None)


def _together(rows: Sequence[Mapping[str, float | int]]) -> dict[str, float]:
    """Means over the seeds, but for the footsteps a second, which add up."""
    names = set.intersection(*(set(row) for row in rows))
    found = {name: float(np.mean([row[name] for row in rows])) for name in names}
    return found | {_RATE: found[_RATE] * len(rows)} if _RATE in found else found
