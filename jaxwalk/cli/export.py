"""``jaxwalk export``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from jaxwalk import files
from jaxwalk.cli import checks
from jaxwalk.cli.parse import Names, Policy, parse
from jaxwalk.errors import UserError

FORMATS = ("safetensors", "npz", "onnx", "stablehlo", "c")


@dataclass(frozen=True)
class ExportArgs:
    """Write a trained policy, with its normaliser, bounds, units and controllers, for other runtimes."""

    policy: Policy
    out: Path
    """Folder for the files, made if it is not there; files of the same names are replaced."""
    format: Names = ("safetensors",)
    """Formats, with commas between: safetensors, npz, onnx, stablehlo, c."""
    verify: bool = False
    """Whether each file is tested in a fresh process against what JAX computes."""

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
        files.check_folder("--out", self.out)


def run(argv: Sequence[str]) -> None:
    args = parse(ExportArgs, argv, "export")
    args.check()

    from jaxwalk import runtime

    runtime.setup()
    from jaxwalk.export import command

    command.main(args)
