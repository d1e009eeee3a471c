"""Any file ends in success or in one clear line that names it, whatever was done to it."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, given, settings

sys.path.append(str(Path(__file__).parent))

import kinds

from jaxwalk.errors import UserError

NAMES = (
    "policy", "exported safetensors", "exported npz", "config.json", "summary.json", "metrics.jsonl",
    "push map", "gait report", "self-test", "picture",
    *(f"results of {part}" for part in kinds.PARTS),
)  # fmt: skip


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return kinds.make(tmp_path_factory.mktemp("fuzz"))


def said(read: Callable[[], object], path: Path) -> str | None:
    """The line that ``read`` ends in, if it does."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # of numbers that no walker has
            read()
        return None
    except UserError as error:
        line = str(error)
        assert str(path) in line or str(path.parent) in line, line
        assert line.isprintable() and len(line) < 1500, line
        return line


def fuzz(kind: kinds.Kind, examples: int) -> None:
    refused: list[str] = []
    count = 0

    # The same examples each time, of which nothing is kept.
    @settings(
        max_examples=examples,
        derandomize=True,
        database=None,
        deadline=None,
        phases=(Phase.generate, Phase.shrink),
        suppress_health_check=list(HealthCheck),
    )
    @given(kind.changes)
    def one(content: bytes) -> None:
        nonlocal count
        count += 1
        kind.path.write_bytes(content)
        line = said(kind.read, kind.path)
        if line is not None:
            refused.append(line)

    whole = kind.path.read_bytes() if kind.path.exists() else None
    try:
        one()
    finally:
        kind.path.unlink(missing_ok=True)
        if whole is not None:
            kind.path.write_bytes(whole)
    assert count >= examples / 2 and len(refused) > count / 5  # or the changes change nothing


@pytest.mark.parametrize("name", NAMES)
def test_changed_files_end_in_success_or_in_one_line(made, name):
    fuzz(made[name], 25 if name.startswith("results") else 200)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_many_more_changed_files(made, name):
    fuzz(made[name], 1000 if name.startswith("results") else 10_000)
