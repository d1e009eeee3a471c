"""Trainings that cost nothing: their score is a function of the configuration."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path
from unittest import mock

from jaxwalk.common.errors import UserError
from jaxwalk.common.files import write_json
from jaxwalk.learn.runs import run_folder
from jaxwalk.learn.train.evaluation import Marks


def score(gamma: float) -> float:
    """Best at 0.5."""
    return 1.0 - (gamma - 0.5) ** 2


def run(config, path: Path, seed, command, watch) -> Path:
    """In place of a run. A gamma above 0.9 fails, one below 0.1 is interrupted by somebody."""
    path.mkdir(parents=True)
    if config.ddpg.gamma > 0.9:
        raise UserError("training diverged")
    value, interrupted = score(config.ddpg.gamma), config.ddpg.gamma < 0.1
    for number in range(config.train.evaluations + 1):
        footsteps = number * config.train.footsteps // config.train.evaluations
        interrupted |= watch(footsteps, Marks(value, 1.0, 1.0, 1.0, 1.0))
        if interrupted:
            break
    told = {"interrupted": interrupted, "footsteps": footsteps, "best": {"score": value}, "finals": []}
    write_json(path / run_folder.SUMMARY, told)
    return path


def sweep(*argv: str) -> int:
    """``jaxwalk sweep`` with these trainings; its exit code."""
    from jaxwalk import cli
    from jaxwalk.learn.sweep import command
    from jaxwalk.learn.train import run as train

    # Nothing is compiled, so nothing has to be forgotten: that takes a second each time.
    with (
        mock.patch.object(train, "run", run),
        mock.patch.object(command.jax, "clear_caches"),
        mock.patch.object(command.gc, "collect"),
    ):
        return cli.main(["sweep", "--preset", "smoke", "--train.evaluations", "4", *argv])


if __name__ == "__main__":
    # Whoever starts several lets them begin together: what takes them longest is to import all this.
    import_module("jaxwalk.learn.sweep.command")
    import_module("jaxwalk.learn.train.run")
    print("ready", flush=True)
    sys.stdin.readline()
    sys.exit(sweep(*sys.argv[1:]))
