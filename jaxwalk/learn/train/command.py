"""``jaxwalk train`` from its options to its run folders."""

from __future__ import annotations

import contextlib
import os
import shlex
from pathlib import Path
from typing import TYPE_CHECKING

from jaxwalk.common.parallel import launch

if TYPE_CHECKING:
    from jaxwalk.learn.train.options import TrainArgs


def main(args: TrainArgs, typed: str) -> None:
    """Run ``jaxwalk train``.

    Args:
      typed: it, as it was given, which the run's record holds.
    """
    with contextlib.ExitStack() as stack:
        if args.distributed:
            stack.enter_context(launch.joined(args.place, f"go on with {_resumed(args)}"))
        _train(args, typed)


def _train(args: TrainArgs, typed: str) -> None:
    import jax  # not before the processes have joined: it starts its devices

    from jaxwalk.common.parallel import collectives
    from jaxwalk.learn.runs import seeds_folder
    from jaxwalk.learn.train import beside, multi_seed, run
    from jaxwalk.model.engine import VARIABLE
    from jaxwalk.task import backend

    if args.distributed and collectives.any_process(backend.problem() is not None)[0]:
        os.environ[VARIABLE] = "off"  # where one process has no native code, none uses it
    if args.resume is None and collectives.first():
        named = any(word.partition("=")[0] == "--preset" for word in shlex.split(typed))
        chosen = "" if named else f", for {jax.default_backend()}"
        print(f"preset {args.preset}{chosen}", flush=True)
    if args.learner == "es":
        from jaxwalk.learn.train.es import run as search

        folder = search.run(args.config, args.run_dir, args.seed, typed)
    elif args.resume is not None:
        folder = resume(args.resume)
    elif args.seeds > 1:
        folder = multi_seed.run_many(args.config, args.run_dir, args.seed, args.seeds, typed)
    else:
        folder = run.run(args.config, args.run_dir, args.seed, typed)
    if collectives.count() == 1 and not seeds_folder.is_parent(folder):
        for line in beside.lines(folder):
            print(line, flush=True)


def resume(folder: Path) -> Path:
    """Go on with what was begun in ``folder``, one training or several, and return it.

    Raises:
      UserError: there is nothing to go on with; or as the training does.
    """
    from jaxwalk.learn.runs import seeds_folder
    from jaxwalk.learn.train import multi_seed, run

    return (multi_seed.resume_many if seeds_folder.is_parent(folder) else run.resume)(folder)


def _resumed(args: TrainArgs) -> str:
    return f"jaxwalk train --distributed --resume {args.resume or args.run_dir or 'RUN'}"
