"""What is said of two evaluations whose outcomes are known, and what ``jaxwalk agreement`` writes."""

from __future__ import annotations

import json

import numpy as np
import pytest
from PIL import Image

from jaxwalk import cli
from jaxwalk.measure.agreement import differences
from jaxwalk.measure.evaluate import evaluation

ZERO = dict.fromkeys(differences.WALKING, 0.0)


def evaluated(survival, **walking):
    """Of pushes of -40 and 40 N s at phases 0 and 0.5."""
    return {
        "walking": ZERO | {"speed_std": 0.0} | walking,
        "pushes": {"impulses": [-40.0, 40.0], "phases": [0.0, 0.5], "survival": survival},
        "threshold": {"forward": 40.0, "backward": None},
        "config": {},
    }


MJX = evaluated([[1.0, 0.5], [1.0, 1.0]], speed_mean=1.0, speed_std=0.03)
MUJOCO = evaluated([[1.0, 0.75], [0.0, 1.0]], speed_mean=1.01, speed_std=0.04)


@pytest.fixture(scope="module")
def found():
    return differences.compare(MJX, MUJOCO, 25, 4)


def test_cells_agree_where_their_intervals_overlap(found):
    # Wilson by hand, z^2 = 3.84146: 4 of 4 is [0.510, 1], 0 of 4 is [0, 0.490], 2 and 3 of 4 are wide.
    cells = found["cells"]
    assert cells["overlap"] == [[True, True], [False, True]]
    assert cells["share_overlapping"] == 0.75
    assert cells["low"][0][1][0] == pytest.approx(0.5101, abs=1e-4)
    assert cells["high"][1][1][0] == pytest.approx(0.4899, abs=1e-4)
    assert cells["difference"] == [[0.0, 0.25], [-1.0, 0.0]]
    assert cells["largest_difference"] == 1.0


def test_all_pushes_together(found):
    first, second = found["pushes"]
    assert (first["survivors"], first["trials"], second["survivors"]) == (14, 16, 11)
    assert first["low"] < 14 / 16 < first["high"]


def test_the_walks_difference_and_what_chance_makes_of_it(found):
    assert found["walking"]["speed_mean"] == pytest.approx(0.01)
    # Two means over 25 walkers: sqrt(0.03^2 + 0.04^2) / 5.
    assert found["walking"]["speed_standard_error"] == pytest.approx(0.01)


def test_the_command_puts_the_same_trials_to_both_engines(monkeypatch, tmp_path, capsys):
    asked = []

    def canned(subject, args, tell):
        asked.append((subject, args))
        tell("walking", 1.0)
        return {"mjx": MJX, "mujoco": MUJOCO}[args.engine]

    monkeypatch.setattr(evaluation, "evaluate", canned)
    out = tmp_path / "new" / "folder"
    options = "--walkers 25 --replicas 4 --impulses -40,40 --phases 2 --height 1.7 --seed 3".split()
    assert cli.main(["agreement", "fixed", "--out", str(out), *options]) == 0
    (subject, first), (_, second) = asked
    assert (first.engine, second.engine) == ("mjx", "mujoco")
    assert {**vars(first), "engine": "mujoco"} == vars(second)
    assert (first.seed, first.impulses, subject.config.body.height) == (3, (-40.0, 40.0), 1.7)
    result = json.loads((out / "agreement.json").read_text())
    assert result["cells"]["share_overlapping"] == 0.75
    assert result["engines"]["mujoco"]["pushes"]["survival"] == MUJOCO["pushes"]["survival"]
    assert result["config"]["body"]["height"] == 1.7
    assert "75.0 %" in capsys.readouterr().out
    with Image.open(out / "agreement.png") as image:
        colours = np.unique(np.asarray(image.convert("RGB")).reshape(-1, 3), axis=0)
    assert len(colours) > 50


def test_mjx_is_set_beside_the_engine_that_is_asked_for(monkeypatch, tmp_path):
    asked = []
    monkeypatch.setattr(evaluation, "evaluate", lambda subject, test, tell: asked.append(test.engine) or MJX)
    assert cli.main(["agreement", "fixed", "--out", str(tmp_path), "--engine", "ode"]) == 0
    assert asked == ["mjx", "ode"]
    assert list(json.loads((tmp_path / "agreement.json").read_text())["engines"]) == asked


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--walkers", "0"], "--walkers 0: give a whole number"),
        (["--phases", "0"], "--phases 0"),
        (["--impulses", "hard"], "'hard'"),
        (["--mass", "-1"], "mass -1"),
        (["--engine", "mjx"], "--engine mjx: MJX is set beside another engine"),
    ],
)
def test_bad_options_are_one_line(options, said, tmp_path, capsys):
    assert cli.main(["agreement", "fixed", "--out", str(tmp_path / "a"), *options]) == 2
    error = capsys.readouterr().err
    assert said in error and error.count("\n") == 1
    assert not (tmp_path / "a").exists()
