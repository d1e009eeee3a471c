"""A run folder: what was asked, what happened, what came of it. Made once, never overwritten.

config.json       configuration, seed, command, hardware, versions
metrics.jsonl     one line for each report of the training loop
events.out.*      the same for TensorBoard
checkpoints/      the policy at each evaluation
policy.safetensors, training.png, summary.json   written by the training loop as it goes
"""

from __future__ import annotations

import datetime
import json
import math
import os
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

from jaxwalk import config_io, runtime
from jaxwalk.config import Config, to_dict
from jaxwalk.errors import UserError
from jaxwalk.files import to_json, write_json

CONFIG, METRICS, SUMMARY = "config.json", "metrics.jsonl", "summary.json"
POLICY, CHECKPOINTS, PICTURE = "policy.safetensors", "checkpoints", "training.png"
_OURS = (CONFIG, METRICS, SUMMARY, POLICY, CHECKPOINTS, PICTURE)


class RunFolder:
    """An open run folder. Use it as a context manager, or ``close`` it.

    Attributes:
      path: the folder.
      policy, picture: where the best policy and the training curves belong.
      checkpoints: an existing folder for the policies at each evaluation.
    """

    def __init__(self, path: Path) -> None:
        from tensorboardX import SummaryWriter  # slow to import, and readers do without

        self.path = path
        self.policy = path / POLICY
        self.picture = path / PICTURE
        self.checkpoints = path / CHECKPOINTS
        self._metrics = (path / METRICS).open("a")
        self._events = SummaryWriter(str(path))

    @classmethod
    def create(cls, path: Path | None, config: Config, seed: int, command: str) -> RunFolder:
        """A new run folder, ``runs/YYYYmmdd-HHMMSS`` unless ``path`` is given.

        Raises:
          UserError: the folder holds a run already, or cannot be written.
        """
        if path is not None:
            check_free(path)
        path = path or _dated()
        record = {"config": to_dict(config), "seed": seed, "command": command, **runtime.hardware()}
        try:
            (path / CHECKPOINTS).mkdir(parents=True)
            write_json(path / CONFIG, record)
            return cls(path)
        except OSError as error:
            raise UserError(_unwritable(path, error.strerror or str(error))) from error

    def log(self, row: Mapping[str, Any]) -> None:
        """Append one line of scalars; ``row["footsteps"]`` is TensorBoard's step."""
        self._metrics.write(to_json(row) + "\n")
        self._metrics.flush()  # a killed run keeps every line
        for name, value in row.items():
            if name != "footsteps" and math.isfinite(value):
                self._events.add_scalar(name, float(value), int(row["footsteps"]))

    def write_summary(self, summary: Mapping[str, Any]) -> None:
        """Write ``summary.json``, whole or not at all."""
        write_json(self.path / SUMMARY, summary)

    def close(self) -> None:
        self._metrics.close()
        self._events.close()

    def __enter__(self) -> RunFolder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def check_free(path: Path) -> None:
    """See that a run can be put into ``path``, without touching it.

    Raises:
      UserError: it holds a run already, or cannot be made or written.
    """
    held = [name for name in _OURS if os.path.lexists(path / name)]
    if held:
        raise UserError(f"{path} already holds a run ({held[0]}): give --run-dir another folder")
    nearest = next(p for p in (path, *path.absolute().parents) if os.path.lexists(p))
    if not nearest.is_dir():
        raise UserError(_unwritable(path, f"{nearest} is not a folder"))
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise UserError(_unwritable(path, f"{nearest} is closed to us"))


def load_config(path: Path) -> Config:
    """The configuration of a run.

    Args:
      path: the run folder, or its ``config.json``.

    Raises:
      UserError: there is none, or it is not one that this version understands.
    """
    file = path / CONFIG if path.is_dir() else path
    try:
        record = json.loads(file.read_text())
    except OSError as error:
        raise UserError(
            f"cannot read {file}: {error.strerror}; give a run folder of jaxwalk train"
        ) from error
    except ValueError as error:
        raise UserError(f"{file} is not JSON: give a run folder of jaxwalk train") from error
    if not isinstance(record, dict) or "config" not in record:
        raise UserError(f"{file} holds no configuration: give a run folder of jaxwalk train")
    try:
        return config_io.from_dict(Config, record["config"])
    except UserError as error:
        raise UserError(f"{file}: {error}") from error


def read_summary(path: Path) -> dict[str, Any]:
    """What a run folder's ``summary.json`` tells; nothing where there is none (a run under way, or killed).

    Raises:
      UserError: it cannot be read, or is damaged.
    """
    file = path / SUMMARY
    try:
        summary = json.loads(file.read_text())
    except FileNotFoundError:
        return {}
    except OSError as error:
        raise UserError(f"cannot read {file}: {error.strerror}; give a folder that can be read") from error
    except ValueError as error:
        raise UserError(f"{file} is not JSON: give a run folder of jaxwalk train") from error
    if not isinstance(summary, dict):
        raise UserError(f"{file} holds no summary: give a run folder of jaxwalk train")
    return summary


def read_metrics(path: Path) -> list[dict[str, Any]]:
    """The rows of a run folder's ``metrics.jsonl``, less a last line cut short."""
    lines = (path / METRICS).read_text().splitlines(keepends=True)
    return [json.loads(line) for line in lines if line.endswith("\n")]


def _dated() -> Path:
    stem = Path("runs") / datetime.datetime.now().strftime("%Y%m%d-%H%M%S")
    path, count = stem, 1
    while os.path.lexists(path):  # two runs begun within a second
        count += 1
        path = stem.with_name(f"{stem.name}-{count}")
    check_free(path)
    return path


def _unwritable(path: Path, reason: str) -> str:
    return f"cannot write the run folder {path}: {reason}; give --run-dir a folder that can be written"
