"""``jaxwalk sweep``: trainings one after another, each with what the study draws for it."""

from __future__ import annotations

import dataclasses
import gc
import math
from pathlib import Path
from typing import TYPE_CHECKING

import jax
from optuna.exceptions import TrialPruned
from optuna.study import Study
from optuna.trial import Trial

from jaxwalk.common import files
from jaxwalk.common.errors import UserError
from jaxwalk.config import Config, validate
from jaxwalk.learn.runs import run_folder
from jaxwalk.learn.sweep import report, space, study
from jaxwalk.learn.train import run
from jaxwalk.learn.train.evaluation import Marks

if TYPE_CHECKING:
    from jaxwalk.learn.sweep.options import SweepArgs

IN_A_ROW = 5  # failures, after which it is no trial's own fault


class Interrupted(Exception):
    """A person, or the system, ended the training."""


def main(args: SweepArgs, typed: str) -> None:
    """Train until the study has ``args.trials`` finished trials, and tell of all of them.

    Raises:
      UserError: the storage or the folder cannot be used, the study is another one, or trials fail in a row.
    """
    dimensions = space.parse(args.set, args.config)
    files.make_folder("--run-dir", args.folder)
    pruner = study.pruner(args.pruner, args.config.train.evaluations)
    found = study.open_study(args.study, args.where, dimensions, args.config, args.seed, pruner)
    with study.one_line_errors(args.where):
        try:
            _Sweep(args, dimensions, found, space.without_password(typed)).go()
        finally:
            report.write(found, dimensions, args, args.folder)


class _Sweep:
    def __init__(
        self, args: SweepArgs, dimensions: tuple[space.Dimension, ...], found: Study, command: str
    ) -> None:
        self.args, self.dimensions, self.study, self.command = args, dimensions, found, command
        self.failures: list[str] = []  # since the last trial that came to its end
        self.interrupted = False

    def go(self) -> None:
        while self._finished() < self.args.trials and not self.interrupted:
            self.study.optimize(self._trial, n_trials=1, catch=(Exception,))
            if len(self.failures) >= IN_A_ROW:
                raise UserError(f"{IN_A_ROW} trials in a row failed, the last one so: {self.failures[-1]}")
            jax.clear_caches()  # no later trial needs these programs
            gc.collect()

    def _finished(self) -> int:
        return len(self.study.get_trials(deepcopy=False, states=study.FINISHED))

    def _trial(self, trial: Trial) -> float:
        """The score of one training, which Optuna notes down; what it raises, too."""
        try:
            score = self._train(trial)
        except TrialPruned:
            self.failures.clear()
            raise
        except (Exception, KeyboardInterrupt) as error:
            message = " ".join(f"{type(error).__name__}: {error}".split())
            message = str(error) if isinstance(error, UserError) else message[:300]
            trial.set_user_attr("error", message)
            print(f"trial {trial.number} failed: {message}", flush=True)
            self.interrupted = isinstance(error, Interrupted)
            self.failures.append(message)
            raise
        self.failures.clear()
        print(f"trial {trial.number}: score {score:.3f}", flush=True)
        return score

    def _train(self, trial: Trial) -> float:
        values = study.suggest(trial, self.dimensions)
        told = ", ".join(f"{name} {report.shown(value)}" for name, value in values.items())
        print(f"trial {trial.number}: {told}", flush=True)
        config = space.changed(self.args.config, values)
        # Nobody goes on with a trial that was killed.
        config = dataclasses.replace(config, train=dataclasses.replace(config.train, checkpoint_seconds=0.0))
        validate.check(config)
        path = self.args.folder / f"trial-{trial.number:04}"
        trial.set_user_attr("folder", path.name)
        watch = _Watch(trial, config)
        run.run(config, path, self.args.seed, self.command, watch)
        return _score(path, watch.pruned)


class _Watch:
    """Tells the study of each evaluation, by its number, and the training whether to end there."""

    def __init__(self, trial: Trial, config: Config) -> None:
        self._trial, self._train = trial, config.train
        self.pruned = False

    def __call__(self, footsteps: int, found: Marks) -> bool:
        number = footsteps * self._train.evaluations // self._train.footsteps
        trial, ended = self._trial, footsteps >= self._train.footsteps
        if number and not ended and math.isfinite(found.score):
            trial.report(found.score, number)
            self.pruned = bool(trial.should_prune())  # or it is one of NumPy's
        return self.pruned


def _score(path: Path, pruned: bool) -> float:
    """What a training is worth: its winner's score in the finals, or else of the best evaluation.

    Raises:
      TrialPruned, Interrupted: it did not come to its end.
    """
    summary = run_folder.read_summary(path)
    if pruned:
        raise TrialPruned
    if summary["interrupted"]:
        raise Interrupted(f"interrupted at {summary['footsteps']:,} footsteps")
    return float((summary["finals"] or [summary["best"]])[0]["score"])
