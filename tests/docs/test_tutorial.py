"""The tutorial's cells run, one after another, at the size that it has for tests."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOK = json.loads((ROOT / "docs" / "tutorial.ipynb").read_text("utf-8"))
CELLS = ["".join(cell["source"]) for cell in NOTEBOOK["cells"] if cell["cell_type"] == "code"]


def test_it_stores_no_outputs_and_compiles():
    assert len(CELLS) >= 8
    assert not [cell for cell in NOTEBOOK["cells"] if cell.get("outputs")]
    for number, cell in enumerate(CELLS):
        compile(cell, f"cell {number}", "exec")


@pytest.mark.slow  # README's Python makes the same calls, tests/learn/train/test_run.py that of a training
def test_its_cells_run(tmp_path):
    # A process of its own, as the reader's: signatures are not checked there, whole numbers will do.
    environment = os.environ | {
        "JAXWALK_TUTORIAL_QUICK": "1",
        "MPLBACKEND": "Agg",
        "PYTHONPATH": str(ROOT),
    }
    done = subprocess.run(
        [sys.executable, "-c", "\n".join([*CELLS, "assert state.obs.shape[0] == 4"])],
        capture_output=True, text=True, env=environment, cwd=tmp_path, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    made = tmp_path / "runs" / "tutorial"
    assert (made / "map" / "map.npz").is_file()
    assert (made / "exported" / "policy.h").is_file()
