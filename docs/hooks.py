"""What MkDocs does besides: pages that are made of README.md and of the commands' own help.

Nothing here touches another host, and what a plugin would fetch from one is taken out of the pages.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import textwrap
from pathlib import Path
from typing import Any

from jaxwalk import cli

ROOT = Path(__file__).resolve().parent.parent
COLUMNS = 80
"""Of a command's help: as wide as the site's text is."""


def help_of(name: str) -> str:
    """What ``jaxwalk NAME --help`` prints."""
    said, before = io.StringIO(), os.environ.get("COLUMNS")
    os.environ["COLUMNS"] = str(COLUMNS)
    try:
        with contextlib.redirect_stdout(said):
            cli.main([name, "--help"])
    finally:
        os.environ.pop("COLUMNS")
        if before is not None:
            os.environ["COLUMNS"] = before
    lines = re.sub(r"\x1b\[[0-9;]*m", "", said.getvalue()).strip().splitlines()
    return "\n".join(textwrap.fill(line, COLUMNS) if len(line) > COLUMNS else line for line in lines)


def commands() -> str:
    """A section for each command, and a list of them before."""
    names = list(cli.COMMANDS)
    listed = [f"| [`{name}`](#{name}) | {cli.COMMANDS[name][1]} |" for name in names]
    sections = [f"## `{name}` {{ #{name} }}\n\n```text\n{help_of(name)}\n```" for name in names]
    return "\n".join(["| command | |", "|---|---|", *listed, ""]) + "\n" + "\n\n".join(sections) + "\n"


def front_page() -> str:
    """README.md, its links as they are from docs/; files that the site has not are named only."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    text = re.sub(r"\[([^]]+)\]\(CITATION\.cff\)", r"`\1`", text)
    return text.replace("](docs/", "](").replace("](CONTRIBUTING.md)", "](contributing.md)")


def contributing() -> str:
    """CONTRIBUTING.md, likewise."""
    return (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").replace("](docs/", "](")


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Called by MkDocs with each page's text."""
    name = page.file.src_uri
    if name == "index.md":
        return front_page()
    if name == "contributing.md":
        return contributing()
    if name == "commands.md":
        return f"{markdown}\n{commands()}"
    return markdown


def on_post_page(output: str, **_: Any) -> str:
    """Called by MkDocs with each page's HTML: other hosts' scripts (MathJax of notebooks) are left out."""
    return re.sub(r'<script[^>]*\ssrc="https?://[^>]*></script>', "", output)
