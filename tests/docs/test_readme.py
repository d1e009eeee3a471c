"""README.md stays short, and its Python runs."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
SMALL = {  # what the README says, and what a test has the time for
    'jw.preset("quick")': 'jw.preset("smoke")',
    "walkers=64, seconds=20": "walkers=8, seconds=5",
    "phases=8, replicas=16": "phases=2, replicas=2",
    "impulses=(-60, -40, 40, 60), phases=8": "impulses=(-40, 40), phases=2",
}


def test_it_is_read_in_a_few_minutes():
    assert len(README.encode()) <= 7000


def test_what_it_links_to_is_there():
    links = re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", README)
    assert len(links) > 15
    assert not [link for link in links if not (ROOT / link).exists()]


def test_each_command_it_gives_is_one():
    from jaxwalk.cli import COMMANDS

    given = re.findall(r"^jaxwalk ([a-z-]+)", README, re.MULTILINE)
    assert len(given) == 5
    assert set(given) <= set(COMMANDS)


# tests/learn/train/test_run.py trains by the same call.
UNTRAINED = """
import inspect, jaxwalk
asked = inspect.signature(jaxwalk.train)
jaxwalk.train = lambda *args, **options: asked.bind(*args, **options) and "shipped"
"""


@pytest.mark.parametrize(
    "first", [UNTRAINED, pytest.param("", marks=pytest.mark.slow)], ids=["untrained", ""]
)
def test_its_python_runs(tmp_path, first):
    (block,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    for large, small in SMALL.items():
        assert large in block
        block = block.replace(large, small)
    # A process of its own, as the reader's: signatures are not checked there, whole numbers will do.
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-c", f"{first}{block}\nassert env.action_size == 2"]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, cwd=tmp_path, check=False)
    assert done.returncode == 0, done.stderr
    assert "forward" in done.stdout
    assert (tmp_path / "maps" / "first" / "map.npz").is_file()
    assert {path.suffix for path in (tmp_path / "exported").iterdir()} >= {".npz", ".h"}
