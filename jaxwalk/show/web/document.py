"""One HTML file that a script draws on: it loads nothing, and what names hold is text, never markup."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html.parser import HTMLParser
from importlib import resources
from typing import Any

import jinja2
from markupsafe import Markup


@dataclass(frozen=True)
class Document:
    """A page of the package ``home``, whose folder holds its page.html, page.css and scripts; page.html ends
    within the footer, which `tail.html` goes on with.

    Attributes:
      home: name of the package.
      scripts: their files in order; `drawing.js` comes before them.
      policy: as it was asked for. lead: one sentence under it.
      facts: (name, value), at the page's foot.
      content: what the scripts draw, plain JSON values.
    """

    home: str
    scripts: Sequence[str]
    policy: str
    lead: str
    facts: Sequence[tuple[str, str]]
    content: Mapping[str, Any]

    @property
    def data(self) -> Markup:
        """``content`` as JSON that ends no script element and opens no comment."""
        text = json.dumps(self.content, separators=(",", ":"), allow_nan=False)
        for sign in "<>&\u2028\u2029":
            text = text.replace(sign, f"\\u{ord(sign):04x}")
        return Markup(text)

    @property
    def style(self) -> Markup:
        """The page's style sheet."""
        return Markup("\n").join([_part(_SHARED, "page.css"), _part(self.home, "page.css")])

    @property
    def script(self) -> Markup:
        """The scripts, as one function that leaves nothing behind."""
        parts = [_part(_SHARED, "drawing.js"), *(_part(self.home, name) for name in self.scripts)]
        return Markup('"use strict";\n(() => {\n') + Markup("\n").join(parts) + Markup("})();\n")

    @property
    def style_hash(self) -> str:
        """The one style sheet that the page's own policy lets a browser apply."""
        return _hash(self.style)

    @property
    def script_hash(self) -> str:
        """The one script that the page's own policy lets a browser run."""
        return _hash(self.script)


_SHARED = "jaxwalk.show.web"


def render(page: Document) -> bytes:
    """The HTML file, UTF-8."""
    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    whole = _part(page.home, "page.html") + _part(_SHARED, "tail.html")
    html = environment.from_string(whole).render(page=page)
    return html.encode(errors="backslashreplace")


def read(page: bytes) -> tuple[dict[str, Any], tuple[str, ...]]:
    """What the scripts of a page made by `render` draw, and the addresses that it would load, found by an
    HTML parser; links that a reader may follow are not among these.

    Raises:
      ValueError: it holds no data, or data that are no JSON.
    """
    parser = _Parser()
    parser.feed(page.decode())
    parser.close()
    return json.loads("".join(parser.data)), tuple(parser.addresses)


class _Parser(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.data: list[str] = []
        self.addresses: list[str] = []
        self._within = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._within = tag == "script" and ("id", "data") in attrs
        for name, value in attrs:
            loads = name in ("src", "srcset", "action", "data") or (name == "href" and tag != "a")
            if loads and not (value or "").startswith("data:"):
                self.addresses.append(value or "")

    def handle_endtag(self, tag: str) -> None:
        self._within = False

    def handle_data(self, data: str) -> None:
        if self._within:
            self.data.append(data)


def _part(home: str, name: str) -> Markup:
    return Markup(resources.files(home).joinpath(name).read_text(encoding="utf-8"))


def _hash(text: str) -> str:
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"
