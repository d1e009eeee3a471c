"""The tutorial's cells run, one after another, at the size that it has for tests."""

import importlib.util
import json
from pathlib import Path

import pytest

NOTEBOOK = json.loads((Path(__file__).resolve().parents[2] / "docs" / "tutorial.ipynb").read_text("utf-8"))
CELLS = ["".join(cell["source"]) for cell in NOTEBOOK["cells"] if cell["cell_type"] == "code"]


def test_it_stores_no_outputs_and_compiles():
    assert len(CELLS) >= 8
    assert not [cell for cell in NOTEBOOK["cells"] if cell.get("outputs")]
    for number, cell in enumerate(CELLS):
        compile(cell, f"cell {number}", "exec")


@pytest.mark.skipif(
    importlib.util.find_spec("jaxwalk.api") is None,
    reason="the tutorial needs jaxwalk.api, which is not there",
)
def test_its_cells_run(tmp_path, monkeypatch):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("JAXWALK_TUTORIAL_QUICK", "1")
    names: dict = {"__name__": "tutorial"}
    for number, cell in enumerate(CELLS):
        exec(compile(cell, f"cell {number}", "exec"), names)
    made = tmp_path / "runs" / "tutorial"
    assert (made / "map" / "map.npz").is_file()
    assert (made / "exported" / "policy.h").is_file()
    assert names["state"].obs.shape[0] == 4
