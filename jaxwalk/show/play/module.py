"""The compiled walkers that pages carry: WebAssembly modules kept beside this file, and what fits them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from importlib import resources
from typing import Any

from jaxwalk.common.errors import UserError
from jaxwalk.config import Config
from jaxwalk.show.play import program

NAMES = ("planned", "told")
"""By who settles a step: compliant legs, or the policy alone (``gait.steps``)."""


@dataclass(frozen=True)
class Module:
    """A compiled walker.

    Attributes:
      code: the WebAssembly module.
      kind: `program.kind` of what it was made for.
      source: `program.digest` of what it was made from. jax: the version that unrolled it.
      given, state: where numbers lie, (at, shape, kind) by name: see `portable.layout`.
    """

    code: bytes
    kind: dict[str, Any]
    source: str
    jax: str
    given: dict[str, Any]
    state: dict[str, Any]


def load(name: str) -> Module:
    """The module called ``name``."""
    home = resources.files(__package__ or "") / "modules"
    return Module((home / f"{name}.wasm").read_bytes(), **json.loads((home / f"{name}.json").read_text()))


def name_of(config: Config, policy: str, adapts: bool) -> str:
    """The name of the module that walks as ``config`` says.

    Args:
      adapts: the policy's answers change; else it does not matter what it is told, and when.

    Raises:
      UserError: there is none.
    """
    name = config.gait.steps
    asked, kept = program.kind(config), load(name).kind
    for key, value in asked.items():
        if key in ("observation", "task.replan") and not adapts:
            continue
        if value != kept.get(key):
            raise UserError(
                f"policy {policy}: a page walks with {key} {kept.get(key)!r}, not {value!r}; "
                "show it by jaxwalk render --out walk.html"
            )
    return name
