"""The page in its two forms, Markdown and HTML, of one and the same content."""

from __future__ import annotations

import base64
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from typing import Any

import jinja2

from jaxwalk.paper.claim import BODIES, Claim
from jaxwalk.paper.verdict import FAILS, HOLDS, OPEN, Check, Verdict, verdict

_MARKS = {True: "yes", False: "no", None: "open"}
_CLASSES = {HOLDS: "holds", FAILS: "fails", OPEN: "open"}


@dataclass(frozen=True)
class Ours:
    """What was measured on one body.

    Attributes:
      body: in words. answers: what the claim says of it, and whether it is so: yes, no, open.
      verdict: on this body alone.
    """

    body: str
    answers: tuple[tuple[str, str], ...]
    verdict: Verdict


@dataclass(frozen=True)
class Told:
    """A claim on the page.

    Attributes:
      claim: it. ours: by body. verdict: over all of them.
      date: when it was measured, ISO 8601. command: that measures it alone.
      png: its figure; None: it has none. width, height: of it in pixels.
    """

    claim: Claim
    ours: tuple[Ours, ...]
    verdict: Verdict
    date: str
    command: str
    png: bytes | None = None
    width: int = 0
    height: int = 0

    @property
    def source(self) -> str:
        """The picture as a data URI."""
        return "" if self.png is None else f"data:image/png;base64,{base64.b64encode(self.png).decode()}"

    @property
    def each(self) -> tuple[str, ...]:
        """The verdict on each body there is, whether it was measured or not."""
        found = {one.body: one.verdict for one in self.ours}
        return tuple(found.get(body, "not measured") for body in BODIES.values())

    @property
    def kind(self) -> str:
        """The name that the style sheet has for its verdict."""
        return _CLASSES[self.verdict]


@dataclass(frozen=True)
class Page:
    """All that the page says.

    Attributes:
      policy: as it was asked for. digest: of its parameters. walls: who walks between walls.
      quick: small samples. claims: in order. command: that made the page. machine: (name, value).
    """

    policy: str
    digest: str
    walls: str
    quick: bool
    claims: Sequence[Told]
    command: str
    machine: tuple[tuple[str, str], ...]

    @property
    def counts(self) -> list[tuple[Verdict, int]]:
        """(verdict, how many claims have it); those that hold first, those that cannot be told last."""
        found = Counter(one.verdict for one in self.claims)
        return [(name, found[name]) for name in (HOLDS, FAILS, OPEN)]


def ours(claim: Claim, numbers: Mapping[Any, Any]) -> tuple[tuple[Ours, ...], Verdict]:
    """What the numbers of each body say, and the verdict over all: every body must say yes."""
    each: dict[Any, Sequence[Check]] = {body: claim.checks(told) for body, told in numbers.items()}
    told = tuple(
        Ours(BODIES[body], tuple((check.says, _MARKS[check.answer]) for check in checks), verdict(checks))
        for body, checks in each.items()
    )
    return told, verdict([check for checks in each.values() for check in checks])


def _tied(text: str) -> str:
    """Numbers and their units stay on one line."""
    return re.sub(r"(?<=[\d+]) (?=%|N s\b|m\b|m/s\b|s\b|rad\b)|(?<=N) (?=s\b)", "\u00a0", text)


def _cell(text: str) -> str:
    """Text in a Markdown table."""
    return text.replace("|", "\\|").replace("\n", " ")


def _render(page: Page, template: str, escape: bool) -> bytes:
    environment = jinja2.Environment(
        autoescape=escape, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True,
        keep_trailing_newline=True,
    )  # fmt: skip
    environment.filters |= {"tied": _tied, "cell": _cell}
    text = resources.files("jaxwalk.paper").joinpath(template).read_text(encoding="utf-8")
    return environment.from_string(text).render(page=page).encode(errors="backslashreplace")


def html(page: Page) -> bytes:
    """One file that loads nothing, for a screen of any width and for paper."""
    return _render(page, "page.html", True)


def markdown(page: Page) -> bytes:
    """The page as Markdown, for a repository's reader; figures are files beside it."""
    return _render(page, "page.md", False)
