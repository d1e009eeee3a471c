"""A training run of a second, once compiled, here or in a process of its own; what must come of it."""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jax

from jaxwalk.common.parallel.launch import Place
from jaxwalk.config.presets import PRESETS
from jaxwalk.learn.policies import policy
from jaxwalk.learn.runs import run_folder

SMOKE = PRESETS["smoke"]
# Some nine reports, updates from the second on, four evaluations, a checkpoint whenever one can be written.
CONFIG = dataclasses.replace(
    SMOKE,
    ddpg=dataclasses.replace(SMOKE.ddpg, warmup=16),
    train=dataclasses.replace(
        SMOKE.train, footsteps=120, windows_per_report=50, evaluations=3, finalists=3, checkpoint_seconds=1e-6
    ),
)
SEED, COMMAND = 3, "jaxwalk train --seed 3"
CLOCKED = {"seconds", "train/footsteps_per_second"}


def shorten(patch: Callable[[Any, str, Any], None]) -> None:
    """Few and short trials in evaluations; programs that are compiled once for all runs of the process."""
    from jaxwalk.common.parallel import devices
    from jaxwalk.learn.train import beside, device_loop, evaluation, finals
    from jaxwalk.learn.train.evaluation import Marks
    from jaxwalk.task import backend

    patch(evaluation, "SECONDS", 1.0)
    patch(evaluation, "PHASES", 1)
    patch(evaluation, "CALM", 2)
    patch(evaluation, "PUSHED", 1)
    patch(evaluation, "MORE_CALM", 2)
    patch(finals, "REPLICAS", 1)
    patch(finals, "MORE", 1)
    patch(beside, "of_rules", lambda config, seed: {"constant": Marks(0.5, 0.5, 0.5, 1.0, 1.0)})
    for one in (devices, backend):
        patch(one, "BLOCK", 4)  # or every batch is filled up to a whole block for each device
    patch(device_loop, "make", functools.cache(device_loop.make))
    patch(device_loop, "returns", functools.cache(device_loop.returns))
    patch(evaluation, "of_learner", functools.cache(evaluation.of_learner))
    patch(finals, "Exam", functools.cache(evaluation.Exam))


def undrawn(patch: Callable[[Any, str, Any], None]) -> None:
    """No pictures: they take longer than all the rest."""
    from jaxwalk.learn.runs import picture

    patch(picture, "training_png", lambda rows, path: path.touch())


def outcome(folder: Path) -> dict[str, Any]:
    """What must be the same however often a run was stopped: all but times."""
    rows, summary = run_folder.read_metrics(folder), run_folder.read_summary(folder)
    return {
        "rows": [{k: v for k, v in row.items() if k not in CLOCKED} for row in rows],
        "summary": {k: v for k, v in summary.items() if "seconds" not in k},
        "policy": _digest(folder / run_folder.POLICY),
        "policies": {path.name: _digest(path) for path in (folder / run_folder.CHECKPOINTS).iterdir()},
        "trained": policy.load(folder / run_folder.POLICY).metadata.command,
    }


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def start(
    folder: Path, resume: bool = False, devices: int | None = None, place: Place | None = None
) -> subprocess.Popen[str]:
    """The run of ``CONFIG``, or its resumption, in a process of its own; one of several, given its place."""
    what = "run.resume(folder)" if resume else "run.run(small.CONFIG, folder, small.SEED, small.COMMAND)"
    program = f"""
import contextlib, pathlib, sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
from jaxwalk.common import runtime
from jaxwalk.common.parallel import launch
from jaxwalk.common.parallel.launch import Place
runtime.setup()
place = {place!r}
with launch.joined(place, "go on") if place else contextlib.nullcontext():
    import small
    from jaxwalk.learn.train import run
    small.shorten(setattr)
    small.undrawn(setattr)
    folder = pathlib.Path({str(folder)!r})
    {what}
"""
    return subprocess.Popen(
        [sys.executable, "-c", program],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env=os.environ | {"JAX_NUM_CPU_DEVICES": str(devices or jax.device_count())},
    )
