"""The page: one HTML file that loads nothing, for a screen of any width and for paper."""

from __future__ import annotations

import base64
import re
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources

import jinja2

from jaxwalk.measure.report.collect import Picture
from jaxwalk.measure.report.words import Section, Table


@dataclass(frozen=True)
class Figure:
    """One part on the page.

    Attributes:
      anchor: of links to it. title: its heading.
      section: what it says.
      picture: None: it has none.
      command: the line that made it.
      date: when, ISO 8601.
      small: measured with a small sample.
    """

    anchor: str
    title: str
    section: Section
    picture: Picture | None
    command: str
    date: str
    small: bool

    @property
    def alt(self) -> str:
        """What the picture shows, for those who do not see it."""
        return " ".join((f"{self.title}.", *self.section.sentences[:1]))

    @property
    def source(self) -> str:
        """The picture as a data URI."""
        return f"data:image/png;base64,{base64.b64encode(self.picture.png).decode()}" if self.picture else ""


@dataclass(frozen=True)
class Page:
    """All that the page says.

    Attributes:
      policy: as it was asked for. digest: of its parameters.
      dates: of the first and the last measurement, as they are shown.
      facts: (name, value) of its origin.
      headline: None: no part has the numbers.
      small: titles of the parts with small samples.
      figures: the parts.
      measured: when, with which seed, and on what each part was measured.
      versions: of the parts. configuration: all fields, by group.
      command: the line that made the page.
    """

    policy: str
    digest: str
    dates: str
    facts: tuple[tuple[str, str], ...]
    headline: Table | None
    small: tuple[str, ...]
    figures: Sequence[Figure]
    measured: Table
    versions: Table
    configuration: tuple[Table, ...]
    command: str


def _tied(text: str) -> str:
    """Numbers and their units stay on one line."""
    return re.sub(r"(?<=[\d+]) (?=%|N s\b|m\b|m/s\b|s\b)|(?<=N) (?=s\b)", "\u00a0", text)


def render(page: Page) -> bytes:
    """The HTML file, UTF-8. What names hold is text, never markup."""
    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["tied"] = _tied
    template = resources.files("jaxwalk.measure.report").joinpath("page.html").read_text(encoding="utf-8")
    # A name that the system keeps in another encoding is shown by its codes.
    return environment.from_string(template).render(page=page).encode(errors="backslashreplace")
