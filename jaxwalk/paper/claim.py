"""What a claim of the paper is made of."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure

from jaxwalk.config import BodyModel
from jaxwalk.paper.verdict import Check

if TYPE_CHECKING:
    from jaxwalk.paper.lab import Lab

Numbers = Mapping[str, Any]
"""What was measured on one body, plain JSON values; checks, table and figure are made of nothing else."""

BODIES: dict[BodyModel, str] = {"planar": "planar body", "walls": "between walls"}


@dataclass(frozen=True)
class Claim:
    """One claim of the paper, put to the test: the ``CLAIM`` of a module of `jaxwalk.paper.claims`.

    The module's functions ``measure``, ``checks``, ``table`` and ``draw`` are those that are told of here.

    Attributes:
      name: on the command line and of its files. title: on the page.
      says: what the paper says. where: in which part of it.
      rule: in words, what `checks` does.
      bodies: on which it is measured. quick: those with ``--quick``.
      measure: measures it on one body, and gives the numbers, which ``paper.json`` keeps.
      checks: holds the numbers of one body against the rule: an answer for each thing that is claimed.
      table: the numbers behind the answers, line by line, all of the same columns.
      draw: its figure, of the bodies that were measured, None if there is nothing to show; None: it has none.
      trainings: names of those that it needs, of `jaxwalk.paper.trainings`.
    """

    name: str
    title: str
    says: str
    where: str
    rule: str
    bodies: tuple[BodyModel, ...]
    quick: tuple[BodyModel, ...]
    measure: Callable[["Lab", BodyModel], Numbers]
    checks: Callable[[Numbers], Sequence[Check]]
    table: Callable[[Numbers], Sequence[Mapping[str, Any]]]
    draw: Callable[[Mapping[BodyModel, Numbers]], Figure | None] | None = None
    trainings: tuple[str, ...] = ()
