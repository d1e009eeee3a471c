"""``jaxwalk export``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from jaxwalk.common import files
from jaxwalk.common.errors import UserError
from jaxwalk.options import checks
from jaxwalk.options.parse import (
    Impulses,
    Names,
    OptionalActuators,
    OptionalModel,
    Policy,
    checked,
    parse_known,
)

FORMATS = ("safetensors", "npz", "onnx", "stablehlo", "c")
PAGE = "html"  # made by jaxwalk render; taken here as of old


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

    @property
    def formats(self) -> tuple[str, ...]:
        """The formats that can be asked for."""
        return FORMATS

    def check(self) -> None:
        """As `Options.check`."""
        checks.policy(self.policy)
        for name in self.format:
            if name not in self.formats:
                raise UserError(f"--format {name!r}: give one or more of {', '.join(FORMATS)}")
        if len(set(self.format)) < len(self.format):
            raise UserError(f"--format {','.join(self.format)}: give each format once")
        files.check_folder("--out", self.out)


@dataclass(frozen=True)
class PageArgs(ExportArgs):
    """With ``--format html``, as pages were once asked for: what `jaxwalk.show.render` takes of these."""

    impulses: Impulses | None = None
    seed: int = 0
    model: OptionalModel = None
    actuators: OptionalActuators = None

    @property
    def formats(self) -> tuple[str, ...]:
        """Those of every export, and ``html``."""
        return *FORMATS, PAGE

    def check(self) -> None:
        """See that the options can be meant, those of the page included."""
        super().check()
        checks.replayed(self.impulses or ())
        checks.seed(self.seed)


@dataclass(frozen=True)
class _Asked:
    format: Names = ()


def read(argv: Sequence[str]) -> ExportArgs:
    """The options, checked.

    Raises:
      UserError: one of them is wrong.
    """
    paged = PAGE in parse_known(_Asked, argv, "export").format
    return checked(PageArgs if paged else ExportArgs, argv, "export")
