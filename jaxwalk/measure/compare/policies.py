"""The policies of a comparison, loaded, and seen to walk in the same world."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jaxwalk.common.errors import UserError
from jaxwalk.config import Config, validate
from jaxwalk.learn.policies import named
from jaxwalk.learn.policies.named import Subject
from jaxwalk.learn.runs import run_folder
from jaxwalk.measure.compare.groups import Entry
from jaxwalk.options import checks

# What makes two walkers' pushes comparable; the rest is the policy's own.
_WORLD = ("body", "physics", "sensors")
_AIM = ("gait.speed_desired", "train.window_ticks")


@dataclass(frozen=True)
class Member:
    """One seed.

    Attributes:
      subject: its policy.
      training: footsteps and seconds of its training, as its run folder tells; None where it does not.
    """

    subject: Subject
    training: dict[str, int | float | None]


def load(entries: Sequence[Entry], **changes: Any) -> list[list[Member]]:
    """The members of each entry.

    Args:
      changes: of every configuration, as `named.load` takes them.

    Raises:
      UserError: a policy or a run folder that cannot be read, or policies that do not walk in one world.
    """
    loaded = [[_member(name, changes) for name in entry.members] for entry in entries]
    first, *others = [member for members in loaded for member in members]
    for other in others:
        check_world(first.subject, other.subject)
    return loaded


def check_world(first: Subject, other: Subject) -> None:
    """See that two policies walk in one world: body, physics, sensors and speed.

    Raises:
      UserError: they do not walk in one world.
    """
    for field, ours, theirs in _differences(first.config, other.config):
        if field.split(".")[0] in _WORLD or field in _AIM:
            raise UserError(
                f"{first.name} and {other.name} differ in {field}: {_shown(ours)} and "
                f"{_shown(theirs)}; give policies of one body, physics, sensors and speed"
            )


def controllers_differ(loaded: Sequence[Sequence[Member]]) -> list[str]:
    """A line for each number of the low-level controllers in which a policy differs from the first one."""
    first, *others = [member.subject for members in loaded for member in members]
    return [
        f"{other.name} walks with {field} {_shown(theirs)}, {first.name} with {_shown(ours)}"
        for other in others
        for field, ours, theirs in _differences(first.config, other.config)
        if field.startswith(("gait.", "task."))
    ]


def _member(name: str, changes: dict[str, Any]) -> Member:
    subject = named.load(name, **changes)
    told = run_folder.read_summary(Path(name)) if name not in checks.BUILT_IN and os.path.isdir(name) else {}
    training = {what: told.get(what) for what in ("footsteps", "seconds")}
    for what, value in training.items():
        if value is not None and (isinstance(value, bool) or not isinstance(value, int | float)):
            raise UserError(f"{Path(name) / run_folder.SUMMARY}: {what} is {value!r:.60}, not a number")
    return Member(subject, training)


def _differences(a: Config, b: Config) -> Iterator[tuple[str, Any, Any]]:
    theirs = dict(validate.leaves(b))
    for field, ours in validate.leaves(a):
        if ours != theirs[field]:
            yield field, ours, theirs[field]


def _shown(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
