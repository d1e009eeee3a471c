"""Several seeds in one program: each is what it would be alone, and all end, fail and go on as one would."""

from __future__ import annotations

import dataclasses
import functools
import json
import os
import signal
import sys
from pathlib import Path

import jax
import numpy as np
import pytest

sys.path.append(str(Path(__file__).parent))

import small

from jaxwalk.common.errors import UserError
from jaxwalk.common.parallel import devices
from jaxwalk.learn.policies import policy
from jaxwalk.learn.runs import run_folder, seeds_folder
from jaxwalk.learn.runs.progress import Progress
from jaxwalk.learn.train import device_loop, lanes
from jaxwalk.learn.train.multi_seed import resume_many, run_many
from jaxwalk.learn.train.trainer import Training
from jaxwalk.measure.compare import groups, policies

CONFIG = dataclasses.replace(small.CONFIG, train=dataclasses.replace(small.CONFIG.train, finalists=1))
FIRST, COUNT = 3, 2
COMMAND = "jaxwalk train --seed 3 --seeds 2"
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module", autouse=True)
def short():
    with pytest.MonkeyPatch.context() as patch:
        small.shorten(patch.setattr)
        small.undrawn(patch.setattr)
        patch.setattr(lanes, "make", functools.cache(lanes.make))
        patch.setattr(lanes, "LaneRunner", functools.cache(lanes.LaneRunner))
        yield


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    return run_many(CONFIG, tmp_path_factory.mktemp("both") / "run", FIRST, COUNT, COMMAND)


def apart(one, other) -> float:
    """The largest difference between two trees of numbers."""
    return max(
        float(np.max(np.abs(np.asarray(a, float) - np.asarray(b, float)), initial=0.0))
        for a, b in zip(jax.tree.leaves(one), jax.tree.leaves(other), strict=True)
    )


def alone(seed: int, reports: int):
    """The state of a seed that is trained by itself, after so many reports."""
    mesh = devices.mesh(1)
    state, advance = device_loop.init(CONFIG, mesh, seed), device_loop.make(CONFIG, mesh)
    for _ in range(reports):
        state = advance(state)
    return state


@pytest.mark.parametrize("turns", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_each_lane_is_the_training_that_it_would_be_alone(turns, monkeypatch):
    """Programs that are compiled otherwise round otherwise, and a walk amplifies that: a second only."""
    monkeypatch.setattr(lanes, "one_by_one", lambda: turns)
    several = [device_loop.init(CONFIG, devices.mesh(1), seed) for seed in (FIRST, FIRST + 1, FIRST + 2)]
    mesh = lanes.mesh(len(several))
    together = lanes.Lanes(CONFIG, several, mesh)
    # The one in the middle pauses for a report.
    for report in range(3):
        together.advance([True, report != 1, True])
    for lane, reports in enumerate((3, 2, 3)):
        mine, own = together.take(lane), alone(FIRST + lane, reports)
        assert float(mine.footsteps) == float(own.footsteps) > 0
        assert int(mine.learner.updates) == int(own.learner.updates)
        assert all(apart(a, b) < 0.03 for a, b in _parts(mine, own))
    assert all(apart(a, b) > 0.3 for a, b in _parts(together.take(0), together.take(2)))


def _parts(one, other):
    return [
        (one.learner.actor, other.learner.actor),
        (one.learner.critic, other.learner.critic),
        (one.steppers.walker.plant.qpos, other.steppers.walker.plant.qpos),
    ]


def test_each_seed_has_a_run_folder_like_any_other(both):
    for seed in range(FIRST, FIRST + COUNT):
        folder = both / f"seed-{seed}"
        assert run_folder.load_config(folder) == CONFIG
        assert run_folder.load_origin(folder).seed == seed
        rows, summary = run_folder.read_metrics(folder), run_folder.read_summary(folder)
        evaluations = {row["footsteps"]: row["eval/score"] for row in rows if "eval/score" in row}
        assert len(evaluations) == CONFIG.train.evaluations + 1
        assert summary["footsteps"] >= CONFIG.train.footsteps and not summary["interrupted"]
        assert summary["best"]["score"] == pytest.approx(max(evaluations.values()))
        kept = policy.load(folder / run_folder.POLICY).metadata
        assert (kept.seed, kept.footsteps) == (seed, summary["best"]["footsteps"])
        assert (folder / run_folder.PICTURE).exists()


def test_the_evaluation_is_the_one_that_the_seed_would_have_alone(both):
    """Before any update, where nothing has rounded otherwise yet."""
    from jaxwalk.learn.ddpg import learner
    from jaxwalk.learn.train import evaluation

    row = run_folder.read_metrics(both / "seed-4")[0]
    found = evaluation.of_learner(CONFIG, devices.mesh(1), 4)(learner.averaged(alone(4, 0).learner))[0]
    assert row["eval/survival"] == found.survival
    assert row["eval/speed"] == pytest.approx(found.speed, abs=1e-3)


def test_mean_and_spread_are_those_of_the_seeds(both):
    told = json.loads((both / "seeds.json").read_text())
    best = [run_folder.read_summary(path)["best"] for path in seeds_folder.members(both)]
    assert [run["seed"] for run in told["runs"]] == told["seeds"] == [3, 4]
    speeds = [one["speed"] for one in best]
    assert told["best"]["speed"]["mean"] == pytest.approx(np.mean(speeds))
    assert told["best"]["speed"]["std"] == pytest.approx(abs(speeds[0] - speeds[1]) / np.sqrt(2))
    assert told["best"]["score"]["most"] == max(one["score"] for one in best)
    assert (both / "seeds.png").read_bytes().startswith(b"\x89PNG")


def test_the_folder_stands_for_all_its_seeds_in_a_comparison(both):
    (one,) = groups.parse([f"ddpg={both}"])
    assert one.members == (str(both / "seed-3"), str(both / "seed-4"))
    assert [member.training["footsteps"] for member in policies.load([one])[0]]
    (plain,) = groups.parse([str(both)])
    assert plain.members == one.members


def test_nothing_is_overwritten(both):
    before = {path: path.stat().st_mtime_ns for path in both.rglob("*")}
    with pytest.raises(UserError, match=r"already holds a run \(seeds.json\)"):
        run_many(CONFIG, both, FIRST, COUNT, COMMAND)
    with pytest.raises(UserError, match="is finished: nothing is left to resume"):
        resume_many(both)
    assert {path: path.stat().st_mtime_ns for path in both.rglob("*")} == before


def test_stopped_by_a_signal_it_goes_on_bit_for_bit(both, tmp_path, monkeypatch):
    shown = []

    def update(*_):
        shown.append(1)
        if len(shown) == 3:
            os.kill(os.getpid(), signal.SIGINT)

    with monkeypatch.context() as patch:
        patch.setattr(Progress, "update", update)
        folder = run_many(CONFIG, tmp_path / "run", FIRST, COUNT, COMMAND)
    for path in seeds_folder.members(folder):
        assert run_folder.read_summary(path)["interrupted"]
        policy.load(path / run_folder.POLICY)
    assert all(run["interrupted"] for run in json.loads((folder / "seeds.json").read_text())["runs"])
    resume_many(folder)
    for ours, theirs in zip(seeds_folder.members(folder), seeds_folder.members(both), strict=True):
        assert small.outcome(ours) == small.outcome(theirs)


@pytest.mark.slow
def test_a_seed_that_fails_ends_alone(tmp_path, monkeypatch, both):
    report = Training.report

    def fail(one, *args):
        if one.seed == FIRST and len(one.rows) > 2:
            raise UserError("training diverged")
        report(one, *args)

    monkeypatch.setattr(Training, "report", fail)
    folder = run_many(CONFIG, tmp_path / "run", FIRST, COUNT, COMMAND)
    first, other = json.loads((folder / "seeds.json").read_text())["runs"]
    assert first["failed"] == "training diverged" and "failed" not in other
    assert small.outcome(folder / "seed-4") == small.outcome(both / "seed-4")
