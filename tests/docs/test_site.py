"""The site: every command is on it, every package is told of, nothing of it is elsewhere, no link is dead."""

import ast
import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from jaxwalk.cli import COMMANDS

ROOT = Path(__file__).resolve().parents[2]
_SPEC = importlib.util.spec_from_file_location("docs_hooks", ROOT / "docs" / "hooks.py")
assert _SPEC is not None and _SPEC.loader is not None
HOOKS = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(HOOKS)

# What a browser fetches by itself: scripts, styles, pictures, fonts, frames; not a link that is clicked.
FETCHED = re.compile(
    r"""<(?:script|img|source|video|audio|iframe|embed)\b[^>]*?\b(?:src|srcset)=["']?((?:https?:)?//[^"'\s>]+)"""
    r"""|<link\b[^>]*?\bhref=["']?((?:https?:)?//[^"'\s>]+)|url\(["']?((?:https?:)?//[^)]+)\)|(@import[^;]+http[^;]+)"""
)


@pytest.fixture(scope="module")
def page() -> str:
    return HOOKS.commands()


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_is_on_the_commands_page(page, name):
    assert f"## `{name}`" in page
    assert f"usage: jaxwalk {name}" in page
    assert f"(#{name})" in page


def test_help_texts_fit_the_page_and_are_plain(page):
    blocks = re.findall(r"```text\n(.*?)\n```", page, re.DOTALL)
    assert len(blocks) == len(COMMANDS)
    assert "\x1b" not in page
    assert max(len(line) for block in blocks for line in block.splitlines()) <= HOOKS.COLUMNS


def test_the_front_page_leads_to_pages_of_the_site():
    links = re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", HOOKS.front_page())
    assert not [link for link in links if not (ROOT / "docs" / link).exists()]


def test_architecture_tells_of_every_package():
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    for path in (ROOT / "jaxwalk").rglob("*.py"):
        package = ".".join(path.parent.relative_to(ROOT / "jaxwalk").parts)
        assert not package or f"| `{package}` |" in text, package


def test_every_python_block_of_the_docs_compiles():
    for path in [ROOT / "README.md", *(ROOT / "docs").glob("*.md")]:
        for block in re.findall(r"```python\n(.*?)```", path.read_text(encoding="utf-8"), re.DOTALL):
            ast.parse(block)


def built(config: Path, out: Path) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"NO_MKDOCS_2_WARNING": "1", "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "-f", str(config), "-d", str(out)]
    return subprocess.run(command, capture_output=True, text=True, env=environment, cwd=ROOT, check=False)


@pytest.fixture(scope="module")
def site(tmp_path_factory) -> Path:
    pytest.importorskip("mkdocs", reason="the extra docs is not installed")
    out = tmp_path_factory.mktemp("site")
    done = built(ROOT / "mkdocs.yml", out)
    assert done.returncode == 0, done.stdout + done.stderr
    return out


def test_it_asks_nothing_of_other_hosts(site):
    pages = [path for path in site.rglob("*") if path.suffix in (".html", ".css", ".svg")]
    assert len(pages) > 15
    found = {str(path.relative_to(site)): FETCHED.findall(path.read_text("utf-8")) for path in pages}
    assert not {name: told for name, told in found.items() if told}


def test_mermaid_and_other_things_that_the_theme_would_fetch_are_not_used(site):
    for path in site.rglob("*.html"):
        assert not re.search(r'class="[^"]*\bmermaid\b', path.read_text("utf-8")), path


@pytest.mark.parametrize("link", ["nowhere.md", "method.md#no-such-heading"])
def test_a_dead_link_fails(site, tmp_path, link):
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "index.md").write_text(f"# Here\n\n[there]({link})\n")
    (tmp_path / "docs" / "method.md").write_text("# Method\n\n[here](index.md)\n")
    text = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    validation = text[text.index("validation:") : text.index("hooks:")]
    (tmp_path / "mkdocs.yml").write_text(f"site_name: x\nstrict: true\n{validation}")
    done = built(tmp_path / "mkdocs.yml", tmp_path / "out")
    assert done.returncode != 0
    assert link.partition("#")[0] in done.stdout + done.stderr
