"""The tables of README.md and docs/ say what the files in docs/results say."""

import importlib.util
import json
import shutil
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[2]


def script(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, ROOT / "scripts" / f"{name}.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


RENDER = script("render_results")


@pytest.mark.parametrize("page", RENDER.PAGES)
def test_text_and_json_agree(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    assert RENDER.BLOCK.search(text)
    assert RENDER.render(text) == text, f"{page} is stale: make results-docs"


def test_every_template_is_used():
    used = "".join((ROOT / page).read_text(encoding="utf-8") for page in RENDER.PAGES)
    for template in (ROOT / "docs" / "templates").glob("[!_]*"):  # the others are parts of these
        assert f"<!-- results:{template.name.removesuffix('.md.j2')} -->" in used


@pytest.fixture
def elsewhere(tmp_path, monkeypatch):
    """Results that may be changed."""
    shutil.copytree(RENDER.RESULTS, tmp_path / "results", ignore=shutil.ignore_patterns("*.png", "*.html"))
    monkeypatch.setattr(RENDER, "RESULTS", tmp_path / "results")
    RENDER.read.cache_clear()
    yield tmp_path / "results"
    RENDER.read.cache_clear()


@pytest.mark.parametrize("change", ["speed", "date", "commit"])
def test_another_result_makes_the_text_stale(elsewhere, change):
    path = elsewhere / "rules" / "compare.json"
    found = json.loads(path.read_text())
    if change == "speed":
        (shipped,) = (one for one in found["policies"] if one["name"] == "shipped")
        shipped["spread"]["speed"]["mean"] += 0.01
    elif change == "date":
        found["date"] = "2031-01-01T00:00:00+00:00"
    else:
        found["commit"] = "0123456789abcdef"
    path.write_text(json.dumps(found))
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    after = RENDER.render(text)
    assert after != text
    if change == "commit":
        assert "commit 0123456" in after


def test_every_measurement_of_the_list_has_a_place_in_docs():
    jobs = script("results").jobs()
    assert len({name for name, *_ in jobs}) == len(jobs)
    names = [name for name, _, _, training in jobs if not training]
    assert not [name for name in names if not (ROOT / "docs" / "results" / name).exists()]


def test_every_command_of_the_list_is_one():
    from jaxwalk.cli import COMMANDS

    for _, command, *_ in script("results").jobs():
        first = command.removeprefix("env JAX_NUM_CPU_DEVICES=1 ").split()
        assert (first[0] == "jaxwalk" and first[1] in COMMANDS) or (ROOT / first[1]).is_file()
