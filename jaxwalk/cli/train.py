"""``jaxwalk train``."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated

import tyro

from jaxwalk import config_io, run_folder
from jaxwalk.cli import checks
from jaxwalk.cli.parse import OptionalFile, parse, parse_known
from jaxwalk.config import Config
from jaxwalk.presets import PRESETS, PresetName


@dataclass(frozen=True)
class _Preset:
    preset: PresetName = "default"


@dataclass(frozen=True)
class TrainArgs:
    """Train a policy into a run folder. Ctrl-C ends early and keeps the best policy."""

    preset: PresetName = "default"
    """The defaults of all options below: what works best, the paper's constants, or a quick trial."""
    run_dir: OptionalFile = None
    """Folder for the results, new or without a run in it. Default: runs/<date>-<time>."""
    seed: int = 0
    """Seed of everything that is drawn at random."""
    config: Annotated[Config, tyro.conf.arg(name="")] = field(default_factory=Config)

    def check(self) -> None:
        """Raises:
        UserError: an option out of its range, or a run folder that cannot be used.
        """
        checks.seed(self.seed)
        config_io.check(self.config)
        if self.run_dir is not None:
            run_folder.check_free(self.run_dir)


def read(argv: Sequence[str]) -> TrainArgs:
    """The options, defaults taken from the preset that is named among them."""
    preset = parse_known(_Preset, argv, "train").preset
    default = TrainArgs(preset=preset, config=PRESETS[preset])
    return parse(TrainArgs, argv, "train", default)


def run(argv: Sequence[str]) -> None:
    args = read(argv)
    args.check()

    from jaxwalk import runtime

    runtime.setup()
    from jaxwalk import train

    train.run(args.config, args.run_dir, args.seed, shlex.join(["jaxwalk", "train", *argv]))
