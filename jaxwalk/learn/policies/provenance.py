"""What every command's JSON says of itself, and reading it back: of whom, how, when, on what."""

from __future__ import annotations

import dataclasses
import datetime
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from jaxwalk.common import runtime, untrusted
from jaxwalk.common.errors import UserError
from jaxwalk.config import Config, of_dict, to_dict
from jaxwalk.learn.policies.named import Subject
from jaxwalk.task import backend

FORMAT = 1
"""Format of the JSON files; a reader refuses others."""
OUTPUTS = ("out", "json", "results")  # options that say where results go, not what they are


def stamp(made_by: str, args: Any, subject: Subject | None, config: Config) -> dict[str, Any]:
    """What goes into a command's JSON beside its numbers.

    Args:
      made_by: the command's name.
      args: its options, a dataclass; where its files go is left out.
      subject: whom it measured; None: several, or nobody.
      config: under which.
    """
    options = {name: value for name, value in dataclasses.asdict(args).items() if name not in OUTPUTS}
    whom = {} if subject is None else {"policy": subject.name, "policy_digest": subject.digest}
    return {
        "format": FORMAT,
        "made_by": made_by,
        **whom,
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "options": options,
        "config": to_dict(config),
        "stepper": backend.stepper_of(config, getattr(args, "engine", "mjx")),
        **runtime.hardware(),
    }


def read(path: Path, made_by: str) -> dict[str, Any]:
    """The JSON that ``jaxwalk made_by`` wrote.

    Raises:
      UserError: it is damaged, of another command, or of another version of the format.
    """
    found = untrusted.read_json(path, _cure(made_by))
    if not isinstance(found, Mapping) or not isinstance(found.get("options"), Mapping):
        raise UserError(f"{path} is no result of jaxwalk {made_by}: {_cure(made_by)}")
    if found.get("format") != FORMAT:
        told = f"format {found['format']!r:.20}" if "format" in found else "no format"
        raise UserError(f"{path} has {told}, this version reads {FORMAT}: {_cure(made_by)}")
    if found.get("made_by") != made_by:
        raise UserError(f"{path} was made by jaxwalk {found.get('made_by')!s:.40}: {_cure(made_by)}")
    return dict(found)


def is_of(told: Mapping[str, Any], subject: Subject) -> bool:
    """Whether ``told``, a stamp or a part of one, is of this very policy under this very configuration.

    A field that is younger than ``told`` had its default then.
    """
    try:
        config = of_dict(told["config"])
    except (UserError, KeyError, TypeError):
        return False
    return told.get("policy_digest") == subject.digest and config == subject.config


def _cure(made_by: str) -> str:
    return f"move it away to have it measured anew, or write it with jaxwalk {made_by}"
