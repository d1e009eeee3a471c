"""Who is compared: POLICY, or seeds of one method as NAME=RUN,RUN,... or a folder of `train --seeds`."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from jaxwalk.common.errors import UserError
from jaxwalk.learn.runs import seeds_folder


@dataclass(frozen=True)
class Entry:
    """One line of the comparison.

    Attributes:
      name: under which it is shown.
      members: POLICY of each seed.
    """

    name: str
    members: tuple[str, ...]


def parse(texts: Sequence[str]) -> list[Entry]:
    """The entries of a command line.

    Raises:
      UserError: none at all, a name or a member twice, or an empty one.
    """
    if not texts:
        raise UserError("nothing to compare: give POLICY or NAME=RUN,RUN,..., one or more of them")
    entries = [_entry(text) for text in texts]
    names = [entry.name for entry in entries]
    for name in names:
        if names.count(name) > 1:
            raise UserError(f"{name!r} is given twice: give each name once, or NAME=RUN,RUN,... another name")
    return entries


def _entry(text: str) -> Entry:
    name, equals, members = text.partition("=")
    if not equals or os.path.exists(text):  # a folder's name may hold an equals sign
        return Entry(text, _all_of(text))
    name, runs = name.strip(), tuple(one for run in members.split(",") for one in _all_of(run.strip()))
    if not name or not all(runs):
        raise UserError(f"{text!r} is no group of seeds: give NAME=RUN,RUN,... without gaps")
    for run in runs:
        if runs.count(run) > 1:
            raise UserError(f"{text!r} has {run!r} twice: give each run once")
    return Entry(name, runs)


def _all_of(run: str) -> tuple[str, ...]:
    """The run itself, or the runs in it where it is a folder of several seeds."""
    return tuple(map(str, seeds_folder.members(Path(run)))) if seeds_folder.is_parent(Path(run)) else (run,)
