"""A training run, from the command's point of view: its folder, its devices, what it prints."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Callable
from pathlib import Path

import jax

from jaxwalk.common.errors import UserError
from jaxwalk.common.interrupt import Stop
from jaxwalk.common.parallel import collectives, devices
from jaxwalk.config import Config
from jaxwalk.learn.runs import run_folder
from jaxwalk.learn.runs.progress import Progress
from jaxwalk.learn.runs.run_folder import RunFolder
from jaxwalk.learn.train import checkpoint, device_loop, out_of_resources
from jaxwalk.learn.train.trainer import Training, Watch
from jaxwalk.task import backend, collect


def run(
    config: Config, run_dir: Path | None, seed: int, command: str, watch: Watch = lambda *_: False
) -> Path:
    """Train, and return the run folder.

    Ctrl-C (or SIGTERM, SIGHUP) ends after the report under way and keeps the best policy so far. Of several
    processes, all call this; the first one writes the folder, which all of them can read.

    Raises:
      UserError: a configuration that cannot be run, a folder that cannot be used, a disk or a memory
        that is full, or a training that diverges again and again.
    """

    def begin() -> RunFolder:
        collect.check(config)
        out_of_resources.check_memory(config, checkpoint.size(device_loop.layout(config)))
        _check_split(config)
        return RunFolder.create(run_dir, config, seed, command)

    folder, identity = _open(begin)
    with folder:
        _train(config, folder, identity, seed, command, resumed=False, watch=watch)
        return folder.path


def resume(path: Path) -> Path:
    """Go on with the run in ``path`` from its latest checkpoint, and return the folder.

    On the same machine, versions and number of devices, all comes bit for bit as if the run had never been
    stopped; on another number of devices, but for rounding.

    Raises:
      UserError: as for ``run``; or there is no run, it is finished, it has no usable checkpoint, or
        another process trains it.
    """
    origin = run_folder.load_origin(path)
    config = run_folder.load_config(path)
    if re.search(r"--learner[ =]es\b", origin.command):
        raise UserError(
            f"the run in {path} is an evolution strategy's, which nobody goes on with: begin it anew"
        )

    def begin() -> RunFolder:
        _check_split(config)
        folder = RunFolder.reopen(path)
        with contextlib.ExitStack() as stack:
            stack.enter_context(folder)
            summary = run_folder.read_summary(path)
            if summary and not summary.get("interrupted"):
                raise UserError(f"the run in {path} is finished: nothing is left to resume")
            stack.pop_all()
        run_folder.say_what_changed(origin.versions, config)
        return folder

    folder, identity = _open(begin)
    with folder:
        _train(config, folder, identity, origin.seed, origin.command, resumed=True)
        return folder.path


def _open(begin: Callable[[], RunFolder]) -> tuple[RunFolder, str]:
    """The folder that the first process opens, and what tells its run from others, in all of them.

    Raises:
      UserError: it cannot be opened.
    """
    mine: list[RunFolder] = []

    def say() -> str:
        mine.append(begin())
        return f"{run_folder.identity(mine[0].path)} {mine[0].path}"

    # Told rather than read: a shared file system may be slow to show the others what was just made.
    identity, _, path = collectives.broadcast(say).partition(" ")
    return (mine[0] if mine else RunFolder(Path(path), writes=False)), identity


def _check_split(config: Config) -> None:
    """See that each device of several processes would have walkers.

    Raises:
      UserError: several processes, and a device that would have no walkers.
    """
    count = jax.device_count()
    if collectives.count() > 1 and devices.mesh(device_loop.blocks(config)).size != count:
        raise UserError(
            f"--train.walkers {config.train.walkers} and --ddpg.batch-size {config.ddpg.batch_size} cannot "
            f"be split over the {count} devices of {collectives.count()} processes: give multiples of "
            f"{count}, or another number of devices"
        )


def _train(
    config: Config,
    folder: RunFolder,
    identity: str,
    seed: int,
    command: str,
    resumed: bool,
    watch: Watch = lambda *_: False,
) -> None:
    mesh = devices.mesh(device_loop.blocks(config))
    if folder.writes:
        several = f" of {collectives.count()} processes" if collectives.count() > 1 else ""
        print(
            f"run folder {folder.path}, devices ({jax.devices()[0].platform}): {mesh.size}{several}, "
            f"stepped by {backend.stepper_of(config)}",
            flush=True,
        )
    with (
        out_of_resources.explained(config, folder.path),
        Progress(config.train.footsteps, folder.writes) as progress,
        Stop() as stop,
        contextlib.closing(
            Training(config, folder, identity, seed, command, mesh, progress, stop)
        ) as training,
    ):
        training.watch = watch
        if resumed:
            training.restore()
        training.go()
