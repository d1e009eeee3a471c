"""The folder of several seeds: a run folder for each, beside what they say together.

seed-K/      the run of seed K, as `jaxwalk train --seed K` makes it
seeds.json   configuration, seeds, command, hardware; what came of each seed; mean and spread
seeds.png    survival, score and speed against footsteps, mean and spread
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from jaxwalk.common import runtime, untrusted
from jaxwalk.common.errors import UserError
from jaxwalk.common.files import make_folder, write_json
from jaxwalk.config import Config, to_dict
from jaxwalk.learn.runs import run_folder

SUMMARY, PICTURE = "seeds.json", "seeds.png"
_CURE = "give the folder of jaxwalk train --seeds"


def folder(parent: Path, seed: int) -> Path:
    """Where the run of a seed belongs."""
    return parent / f"seed-{seed}"


def is_parent(path: Path) -> bool:
    """Whether runs of several seeds lie in ``path``."""
    return os.path.isfile(path / SUMMARY)


def check_free(path: Path) -> None:
    """See that runs can be put into ``path``, without touching it.

    Raises:
      UserError: it holds some already, or cannot be made or written.
    """
    run_folder.check_free(path)
    held = [name for name in (SUMMARY, PICTURE) if os.path.lexists(path / name)]
    held += sorted(str(one.name) for one in path.glob("seed-*"))
    if held:
        raise UserError(f"{path} already holds a run ({held[0]}): give --run-dir another folder")


def create(path: Path | None, config: Config, seeds: Sequence[int], command: str) -> Path:
    """A new folder for ``seeds``, ``runs/YYYYmmdd-HHMMSS`` unless ``path`` is given.

    Raises:
      UserError: it holds runs already, or cannot be written.
    """
    path = path or run_folder.dated()
    check_free(path)
    make_folder("--run-dir", path)
    told = {"config": to_dict(config), "seeds": list(seeds), "command": command, **runtime.hardware()}
    write_json(path / SUMMARY, told)
    return path


def load(path: Path) -> list[int]:
    """The seeds whose runs lie in ``path``.

    Raises:
      UserError: there are none, or ``seeds.json`` is damaged.
    """
    seeds = read(path).get("seeds")
    if not isinstance(seeds, list) or not seeds or not all(type(seed) is int for seed in seeds):
        raise UserError(f"{path / SUMMARY} names no seeds: {_CURE}")
    return seeds


def members(path: Path) -> list[Path]:
    """The run folders in ``path``.

    Raises:
      UserError: as for ``load``.
    """
    return [folder(path, seed) for seed in load(path)]


def read(path: Path) -> dict[str, Any]:
    """What ``seeds.json`` in ``path`` tells.

    Raises:
      UserError: it cannot be read, or is damaged.
    """
    told = untrusted.read_json(path / SUMMARY, _CURE)
    if not isinstance(told, dict):
        raise UserError(f"{path / SUMMARY} names no seeds: {_CURE}")
    return told
