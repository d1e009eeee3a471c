"""``jaxwalk export``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from jaxwalk.common import files
from jaxwalk.common.errors import UserError
from jaxwalk.options import checks
from jaxwalk.options.parse import Impulses, Names, OptionalModel, Policy, checked

FORMATS = ("safetensors", "npz", "onnx", "stablehlo", "c", "html")
IMPULSES = (-80.0, -40.0, 40.0, 70.0)
MOST_IMPULSES = 12  # the page stays below a megabyte


@dataclass(frozen=True)
class ExportArgs:
    """Write a trained policy, with its normaliser, bounds, units and controllers, for other runtimes; or any
    policy's walks as a page to watch."""

    policy: Policy
    out: Path
    """Folder for the files, made if it is not there; files of the same names are replaced."""
    format: Names = ("safetensors",)
    """Formats, with commas between: safetensors, npz, onnx, stablehlo, c; html: a page that replays walks."""
    verify: bool = False
    """Whether each file is tested in a fresh process against what JAX computes; the page is read back."""
    impulses: Impulses = IMPULSES
    """html: pushes to replay beside the unpushed walk, N s; positive ones push forward."""
    seed: int = 0
    """html: seed of the walks' start and of the sensors' noise."""
    model: OptionalModel = None

    def check(self) -> None:
        """Raises:
        UserError: an option out of its range.
        """
        checks.policy(self.policy)
        for name in self.format:
            if name not in FORMATS:
                raise UserError(f"--format {name!r}: give one or more of {', '.join(FORMATS)}")
        if len(set(self.format)) < len(self.format):
            raise UserError(f"--format {','.join(self.format)}: give each format once")
        if "html" not in self.format:
            replayed = (
                ("--impulses", self.impulses, IMPULSES),
                ("--seed", self.seed, 0),
                ("--model", self.model, None),
            )
            for option, value, default in replayed:
                if value != default:
                    raise UserError(f"{option}: is for walks that are replayed; add --format html")
        checks.impulses("--impulses", self.impulses)
        if len(self.impulses) > MOST_IMPULSES:
            raise UserError(f"--impulses with {len(self.impulses)}: give {MOST_IMPULSES} at most")
        checks.seed(self.seed)
        files.check_folder("--out", self.out)


def read(argv: Sequence[str]) -> ExportArgs:
    """The options, checked.

    Raises:
      UserError: one of them is wrong.
    """
    return checked(ExportArgs, argv, "export")
