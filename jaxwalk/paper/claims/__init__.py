"""The claims, in the order of the page: each is a module that measures, judges and draws."""

from __future__ import annotations

from importlib import import_module

from jaxwalk.paper.claim import Claim
from jaxwalk.paper.options import NAMES


def registry() -> dict[str, Claim]:
    """All claims by their names."""
    return {name: import_module(f"jaxwalk.paper.claims.{name}").CLAIM for name in NAMES}
