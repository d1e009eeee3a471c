"""The study: where its trials are kept, who draws them, and which are given up early."""

from __future__ import annotations

import contextlib
import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
import optuna
from optuna.distributions import BaseDistribution
from optuna.pruners import BasePruner, HyperbandPruner, MedianPruner, NopPruner
from optuna.samplers import BaseSampler, TPESampler
from optuna.study import Study
from optuna.trial import FrozenTrial, Trial, TrialState

from jaxwalk.common import files
from jaxwalk.common.errors import UserError
from jaxwalk.config import Config, of_dict, to_dict
from jaxwalk.learn.sweep import space
from jaxwalk.learn.sweep.space import Dimension, Range

PrunerName = Literal["median", "hyperband", "none"]
FINISHED = (TrialState.COMPLETE, TrialState.PRUNED)
_KEY = "jaxwalk"  # the study's attribute that says what is searched
_HEARTBEAT, _GRACE = 60, 300  # s; a database takes a trial for failed that has been silent for so long


class ByNumber(BaseSampler):
    """TPE (Bergstra et al. 2011) whose draws depend on the seed, the trial's number and the study so far.

    So processes that share a study, all with one seed, never draw the same.
    """

    def __init__(self, seed: int) -> None:
        self._seed, self._number, self._own = seed, -1, TPESampler()

    def _of(self, trial: FrozenTrial) -> TPESampler:
        if trial.number != self._number:
            draws = np.random.SeedSequence([self._seed, trial.number]).generate_state(1)
            self._number, self._own = trial.number, TPESampler(seed=int(draws[0]))
        return self._own

    def infer_relative_search_space(self, study: Study, trial: FrozenTrial) -> dict[str, BaseDistribution]:
        """The options that are drawn together, as the trial's own TPE says."""
        return self._of(trial).infer_relative_search_space(study, trial)

    def sample_relative(
        self, study: Study, trial: FrozenTrial, search_space: dict[str, BaseDistribution]
    ) -> dict[str, Any]:
        """The values of those, by their names."""
        return self._of(trial).sample_relative(study, trial, search_space)

    def sample_independent(
        self, study: Study, trial: FrozenTrial, param_name: str, param_distribution: BaseDistribution
    ) -> Any:
        """The value of an option that is drawn by itself."""
        return self._of(trial).sample_independent(study, trial, param_name, param_distribution)

    def after_trial(
        self, study: Study, trial: FrozenTrial, state: TrialState, values: Sequence[float] | None
    ) -> None:
        """Tell the trial's own TPE that the trial has ended."""
        self._of(trial).after_trial(study, trial, state, values)


def pruner(name: PrunerName, evaluations: int) -> BasePruner:
    """Who gives up trials, by their scores at the evaluations, of which there are so many after the first.

    ``median`` compares with the median of the others there, from a quarter of the training on and once
    five trials have ended; ``hyperband`` is Li et al. 2018's, thirds.
    """
    assert name in get_args(PrunerName)
    if name == "median":
        return MedianPruner(n_startup_trials=5, n_warmup_steps=evaluations // 4)
    if name == "hyperband":
        return HyperbandPruner(min_resource=1, max_resource=evaluations, reduction_factor=3)
    return NopPruner()


def suggest(trial: Trial, dimensions: Sequence[Dimension]) -> dict[str, float | int | str]:
    """The values of one trial, by the names of their fields."""
    found: dict[str, float | int | str] = {}
    for one in dimensions:
        if not isinstance(one, Range):
            found[one.name] = trial.suggest_categorical(one.name, one.texts)
        elif one.whole:
            found[one.name] = trial.suggest_int(one.name, int(one.low), int(one.high), log=one.log)
        else:
            found[one.name] = trial.suggest_float(one.name, one.low, one.high, log=one.log)
    return found


def open_study(
    name: str, storage: str, dimensions: Sequence[Dimension], config: Config, seed: int, pruner: BasePruner
) -> Study:
    """The study ``name`` in ``storage``, made there if it is new.

    Args:
      storage: a database's URL, or the path of a journal.
      config: of what is not searched. seed: of the sampler and of every training.

    Raises:
      UserError: the storage cannot be used, or has a study of that name that searches something else.
    """
    ours = {"space": space.to_json(dimensions), "config": to_dict(config), "seed": seed}
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    with one_line_errors(storage):
        study = optuna.create_study(
            storage=_open(storage),
            study_name=name,
            sampler=ByNumber(seed),
            pruner=pruner,
            direction="maximize",
            load_if_exists=True,
        )
        if not study.user_attrs and not study.get_trials(deepcopy=False):
            study.set_user_attr(_KEY, ours)
        theirs = study.user_attrs.get(_KEY)
    where = space.without_password(storage)
    if theirs is None:
        raise UserError(f"study {name} in {where} is not of jaxwalk sweep: give another --study")
    plain = _plain(ours)
    for what in ("space", "config", "seed"):
        if theirs.get(what) != plain[what] and not (what == "config" and _is(theirs.get(what), config)):
            meant = {"space": "--set", "config": "options of train", "seed": "--seed"}[what]
            raise UserError(
                f"study {name} in {where} was begun with other {meant}: give the same, or another --study"
            )
    return study


def _is(told: Any, config: Config) -> bool:
    """Whether ``told``, of this version or an earlier one, stands for ``config``."""
    try:
        return of_dict(told) == config
    except UserError:
        return False


def _plain(value: Any) -> Any:
    """``value`` as it comes back from JSON: tuples become lists."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    return [_plain(item) for item in value] if isinstance(value, list | tuple) else value


def _open(storage: str) -> optuna.storages.BaseStorage:
    if "://" not in storage:
        from optuna.storages.journal import JournalFileBackend, JournalFileSymlinkLock, JournalStorage

        class Lock(JournalFileSymlinkLock):
            """Optuna's, which whoever appends holds; a line that was cut short is nobody's then."""

            def acquire(self) -> bool:
                acquired = super().acquire()
                files.drop_stump(Path(storage))
                return acquired

        Path(storage).parent.mkdir(parents=True, exist_ok=True)
        return JournalStorage(JournalFileBackend(storage, Lock(storage)))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
        return optuna.storages.RDBStorage(storage, heartbeat_interval=_HEARTBEAT, grace_period=_GRACE)


@contextlib.contextmanager
def one_line_errors(storage: str) -> Iterator[None]:
    """Within it, what goes wrong with the storage becomes one line for the user.

    Raises:
      UserError: what is done in here with the storage fails.
    """
    from sqlalchemy.exc import SQLAlchemyError

    # Optuna asserts that a trial's end was noted, which a storage that is gone cannot do.
    known = (ImportError, OSError, ValueError, AssertionError, SQLAlchemyError, optuna.exceptions.OptunaError)
    try:
        yield
    except known as error:
        where = space.without_password(storage)
        message = space.without_password(" ".join(str(getattr(error, "orig", None) or error).split()))
        raise UserError(
            f"--storage {where}: cannot be used ({message:.200}); give a journal's path, or the URL of a "
            "database that answers"
        ) from error
