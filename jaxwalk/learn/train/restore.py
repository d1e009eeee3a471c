"""A run as its latest checkpoint left it, on whatever devices there are now."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jax.sharding import Mesh

from jaxwalk.common import files
from jaxwalk.common.errors import UserError
from jaxwalk.config import Config
from jaxwalk.learn.policies import policy
from jaxwalk.learn.policies.policy import Policy
from jaxwalk.learn.runs import run_folder
from jaxwalk.learn.runs.run_folder import RunFolder
from jaxwalk.learn.train import checkpoint, device_loop
from jaxwalk.learn.train.checkpoint import Checkpoint, Store
from jaxwalk.learn.train.device_loop import TrainState
from jaxwalk.learn.train.run_state import Past, Record


@dataclass(frozen=True)
class Restored:
    """What a run goes on with.

    Attributes:
      state: on the devices.
      good: where it goes back to when it diverges.
      record: what it knows. rows: of metrics so far.
      finalists: policies and their scores.
    """

    state: TrainState
    good: Checkpoint
    record: Record
    rows: list[dict[str, Any]]
    finalists: Sequence[tuple[Policy, float]]


def latest(
    config: Config, mesh: Mesh, folder: RunFolder, store: Store, say: Callable[[str], None]
) -> Restored | None:
    """The run of the latest checkpoint; what came after it is dropped from the folder.

    None: it was killed before there was one, and begins anew; the metrics do, too.

    Raises:
      UserError: there is none that can be used, or the folder lacks what it knows of.
    """
    like, where = device_loop.layout(config), device_loop.shardings(mesh)
    found = store.latest(say, 2 * checkpoint.size(like))
    if found is None:
        # The first checkpoint follows the first evaluation at once.
        if len(run_folder.read_metrics(folder.path)) > 1:
            raise UserError(f"the run in {folder.path} holds no checkpoint to resume from: begin a new run")
        folder.keep(0)
        return None
    try:
        now, good = (found.notes[name] for name in ("now", "good"))
        past, _ = Past.from_notes(now), Past.from_notes(good)
    except (KeyError, TypeError, ValueError, AttributeError):
        raise UserError(
            f"the checkpoint in {folder.resume} is of another version of jaxwalk: its notes do not "
            "fit; go on with the version that made it"
        ) from None
    state = checkpoint.unpack(_under("now.", found.arrays), like, where)
    back = checkpoint.unpack(_under("good.", found.arrays), like, where)
    finalists = [(_load(config, folder, footsteps), score) for footsteps, score in past.finalists]
    if past.record.found:
        _load(config, folder, past.record.best)
    rows = folder.keep(past.rows)
    if folder.writes:
        _forget_what_came_later(folder, past.record)
    folder.drop_summary()
    return Restored(state, Checkpoint(checkpoint.pack(back), good), past.record, rows, finalists)


def _forget_what_came_later(folder: RunFolder, record: Record) -> None:
    """The policies in the folder become those that the record knows."""
    for file in folder.checkpoints.glob("*.safetensors"):
        if file.stem.isdecimal() and int(file.stem) > record.evaluated:
            file.unlink()
    if record.found:
        files.write_bytes(folder.policy, folder.candidate(record.best).read_bytes())


def _load(config: Config, folder: RunFolder, footsteps: int) -> Policy:
    """The policy of an evaluation.

    Raises:
      UserError: it is gone, damaged, or not of this run's kind.
    """
    file = folder.candidate(footsteps)
    found = policy.load(file)
    told = found.metadata
    if (told.hidden, told.observation_names) != (config.ddpg.hidden, config.observation):
        raise UserError(f"policy {file} is not of the run that it lies in: begin a new run")
    return found


def _under(prefix: str, arrays: Any) -> dict[str, np.ndarray]:
    return {name.removeprefix(prefix): x for name, x in arrays.items() if name.startswith(prefix)}
