"""The results of a policy: those in the folder, and those that are measured because they are not."""

from __future__ import annotations

import importlib
import io
import os
import struct
import warnings
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from PIL import Image

from jaxwalk.common import files, untrusted
from jaxwalk.common.errors import UserError
from jaxwalk.config import validate
from jaxwalk.learn.policies import named, provenance
from jaxwalk.learn.policies.named import Subject
from jaxwalk.measure.report.parts import Part

MAX_PICTURE = 16 * 2**20  # bytes; the largest has a fifth of one megabyte
# Pillow's words for a PNG that is damaged (SyntaxError among them) or has too many pixels.
_DAMAGED_PNG = (
    OSError, SyntaxError, ValueError, EOFError, struct.error, zlib.error, Image.DecompressionBombError,
    Image.DecompressionBombWarning,
)  # fmt: skip
_CHANGES = ("speed", "height", "mass", "noise", "model")  # options that change the policy's configuration


@dataclass(frozen=True)
class Picture:
    """A PNG file's content, and its size in pixels."""

    png: bytes
    width: int
    height: int


@dataclass(frozen=True)
class Found:
    """One part's results.

    Attributes:
      part: which.
      path: of its JSON.
      result: its content.
      args: the options that it was made with.
      picture: None: the part has none.
    """

    part: Part
    path: Path
    result: dict[str, Any]
    args: Any
    picture: Picture | None


def find(part: Part, policy: str, folder: Path) -> Found | None:
    """The results in ``folder``, if there.

    Raises:
      UserError: they are damaged, or of another policy, configuration, command or version.
    """
    home = folder / part.command
    path = home / part.json
    if not os.path.lexists(path):
        return None
    result = provenance.read(path, part.command)
    try:
        plain = {name: str(value) for name, value in part.place(folder).items()}
        args = validate.from_dict(part.kind, result["options"] | plain)
        changes = {name: getattr(args, name) for name in _CHANGES if hasattr(args, name)}
        subject = _subject(args, policy, changes)
    except (UserError, TypeError, ArithmeticError) as error:
        raise UserError(f"{path}: its options do not fit this version ({error}): move it away") from None
    if not _is_of(result, subject):
        raise UserError(
            f"{path} is of another policy or configuration than {policy}: give --results another folder, or "
            "move it away to have it measured anew"
        )
    return Found(part, path, result, args, None if part.png is None else _picture(home / part.png, path))


def measure(part: Part, policy: str, folder: Path, quick: bool, seed: int) -> None:
    """Run the command, whose files go into ``folder``.

    Raises:
      UserError: what the command itself finds wrong.
    """
    args = part.args(policy, folder, quick, seed)
    files.make_folder("--results", folder / part.command)
    args.check()
    importlib.import_module(part.module).main(args)


def _subject(args: Any, policy: str, changes: dict[str, Any]) -> Subject | None:
    """Whom results with such options are about; None: nobody."""
    about = hasattr(args, "policy") or hasattr(args, "policies")
    return named.load(policy, **changes) if about else None


def _is_of(result: dict[str, Any], subject: Subject | None) -> bool:
    if subject is None:
        return True  # the part is about no policy
    return any(provenance.is_of(told, subject) for told in (result, *members(result)))


def members(result: dict[str, Any]) -> list[dict[str, Any]]:
    """The policies that a comparison measured, seed by seed; none for other commands."""
    found = result.get("policies")
    if not isinstance(found, list):
        return []
    try:
        return [member for policy in found for member in policy["members"] if isinstance(member, dict)]
    except (KeyError, TypeError):
        return []


def _picture(path: Path, beside: Path) -> Picture:
    cure = f"move {beside} away to have both made anew"
    content = untrusted.content(path, MAX_PICTURE, cure)
    try:
        # Its pixels are for the reader of the page to unpack.
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            with Image.open(io.BytesIO(content), formats=["PNG"]) as image:
                image.verify()
                return Picture(content, *image.size)
    except _DAMAGED_PNG as error:
        raise UserError(untrusted.unreadable(path, f"{error!s:.100}", cure)) from None
