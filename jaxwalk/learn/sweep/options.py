"""``jaxwalk sweep``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Literal

import tyro

from jaxwalk.common import files
from jaxwalk.common.errors import UserError
from jaxwalk.config import Config, validate
from jaxwalk.config.presets import PRESETS, PresetName, of_machine
from jaxwalk.learn.sweep import space
from jaxwalk.options import checks
from jaxwalk.options.parse import OptionalFile, OptionalPreset, checked, parse_known

Sets = Annotated[tuple[str, ...], tyro.conf.arg(metavar="OPTION=LOW:HIGH[:log]|OPTION=VALUE,VALUE")]
OptionalText = Annotated[str | None, tyro.conf.arg(metavar="URL|PATH")]


@dataclass(frozen=True)
class _Origin:
    preset: OptionalPreset = None


@dataclass(frozen=True)
class SweepArgs:
    """Search training's options; several machines may share one study. Ctrl-C ends it, the study stays."""

    set: Sets
    """What is searched: options of train, each with a range (:log for an even spread in the logarithm) or
    values; lists as 'ddpg.hidden=64 64|128 128'."""
    study: str
    """Name of the study; one that exists is gone on with."""
    trials: int = 50
    """Finished trials, pruned ones included, that the study shall have, whoever trained them."""
    storage: OptionalText = None
    """Where the study is kept: a journal's path, which may lie on NFS, or a database's URL, as
    postgresql://... or, on one machine, sqlite:///sweep.db. Default: study.journal in --run-dir."""
    pruner: Literal["median", "hyperband", "none"] = "median"
    """Who gives up trials by their evaluations."""
    preset: PresetName = "default"
    """The defaults of all options below."""
    run_dir: OptionalFile = None
    """Folder for the trials' run folders and the results. Default: runs/<study>."""
    seed: int = 0
    """Seed of what is drawn, and of every training."""
    config: Annotated[Config, tyro.conf.arg(name="")] = field(default_factory=Config)

    @property
    def folder(self) -> Path:
        """The folder of the trials and the results."""
        return self.run_dir or Path("runs") / self.study

    @property
    def where(self) -> str:
        """Where the study is kept: a path or a URL."""
        return self.storage or str(self.folder / "study.journal")

    def check(self) -> None:
        """See that the options can be meant.

        Raises:
          UserError: an option out of its range, a space without sense, or a folder that cannot be used.
        """
        if not self.study or "/" in self.study or self.study.startswith("."):
            raise UserError(f"--study {self.study}: give a name that a folder can have")
        checks.whole("--trials", self.trials)
        checks.seed(self.seed)
        validate.check(self.config)
        space.parse(self.set, self.config)
        files.check_folder("--run-dir", self.folder)


def read(argv: Sequence[str]) -> SweepArgs:
    """The options, defaults taken from the preset that is named among them.

    Raises:
      UserError: an option that is wrong, or Optuna is not installed.
    """
    preset = parse_known(_Origin, argv, "sweep").preset or of_machine()
    default = SweepArgs(set=tyro.MISSING, study=tyro.MISSING, preset=preset, config=PRESETS[preset])
    args = checked(SweepArgs, argv, "sweep", default)
    if find_spec("optuna") is None:
        raise UserError("jaxwalk sweep needs the package optuna: pip install 'jaxwalk[sweep]'")
    return args
