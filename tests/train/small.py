"""A training run of seconds, once compiled, in a process of its own; what it leaves is told in digests."""

from __future__ import annotations

import dataclasses
import hashlib
import os
import subprocess
import sys
from pathlib import Path

from jaxwalk import policy, run_folder
from jaxwalk.config import Config
from jaxwalk.presets import PRESETS

SMOKE = PRESETS["smoke"]
# Some nine reports, updates from the second on, three evaluations, a checkpoint after every report.
CONFIG = dataclasses.replace(
    SMOKE,
    ddpg=dataclasses.replace(SMOKE.ddpg, warmup=16),
    train=dataclasses.replace(
        SMOKE.train, footsteps=120, windows_per_report=20, evaluations=2, checkpoint_seconds=1e-6
    ),
)
CLOCKED = {"seconds", "train/footsteps_per_second"}


def shorten(patch) -> None:
    """Evaluations of two seconds."""
    from jaxwalk.train import assess, finals

    patch(assess, "SECONDS", 2.0)
    patch(assess, "PHASES", 1)
    patch(assess, "CALM", 2)
    patch(finals, "REPLICAS", 1)


def outcome(folder: Path) -> dict[str, object]:
    """What must be the same however often a run was stopped."""
    rows = run_folder.read_metrics(folder)
    summary = run_folder.read_summary(folder)
    best = policy.load(folder / run_folder.POLICY)
    return {
        "rows": [{k: v for k, v in row.items() if k not in CLOCKED} for row in rows],
        "policy": hashlib.sha256((folder / run_folder.POLICY).read_bytes()).hexdigest(),
        "footsteps": best.metadata.footsteps,
        "policies": {
            path.name: hashlib.sha256(path.read_bytes()).hexdigest()
            for path in (folder / run_folder.CHECKPOINTS).iterdir()
        },
        "summary": {k: v for k, v in summary.items() if "seconds" not in k},
    }


def start(folder: Path, *, resume: bool = False, before: str = "", **options) -> subprocess.Popen[str]:
    """The run, or its resumption, in another process; ``before`` is run there first."""
    what = "resume(folder)" if resume else "run(small.CONFIG, folder, 3, 'jaxwalk train --seed 3')"
    program = f"""
import sys, pathlib
sys.path.insert(0, {str(Path(__file__).parent)!r})
from jaxwalk import cli, runtime
runtime.setup()
import small
small.shorten(setattr)
from jaxwalk.train import run, resume
folder = pathlib.Path({str(folder)!r})
{before}
def go(argv):
    {what}
sys.modules["jaxwalk.cli.train"] = type(sys)("train")
sys.modules["jaxwalk.cli.train"].run = go
sys.exit(cli.main(["train"]))
"""
    return subprocess.Popen(
        [sys.executable, "-c", program],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"JAX_NUM_CPU_DEVICES": "1"},
        **options,
    )


def config(**train: object) -> Config:
    """``CONFIG`` with other values in ``train``."""
    return dataclasses.replace(CONFIG, train=dataclasses.replace(CONFIG.train, **train))
