"""A whole training run, small: what it leaves behind, and how it ends."""

from __future__ import annotations

import dataclasses
import json
import os
import signal
import sys
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

sys.path.append(str(Path(__file__).parent))

import small

import jaxwalk as jw
from jaxwalk.common.errors import UserError
from jaxwalk.common.parallel import devices
from jaxwalk.learn.policies import policy
from jaxwalk.learn.runs import run_folder
from jaxwalk.learn.runs.progress import Progress
from jaxwalk.learn.train import device_loop, evaluation, finals
from jaxwalk.learn.train.run import run
from jaxwalk.task import collect

CONFIG = small.CONFIG  # whose programs other tests need, too


@pytest.fixture(scope="module", autouse=True)
def short():
    with pytest.MonkeyPatch.context() as patch:
        small.shorten(patch.setattr)
        yield


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run") / "a"
    run(CONFIG, folder, 3, "jaxwalk train --seed 3")
    return folder


def test_from_python_it_is_the_same(finished, tmp_path):
    made = jw.train(CONFIG, tmp_path / "b", seed=3)
    assert small.outcome(made)["rows"] == small.outcome(finished)["rows"]


def test_run_folder_is_whole(finished):
    names = {path.name for path in finished.iterdir()}
    assert {
        "config.json",
        "metrics.jsonl",
        "checkpoints",
        "policy.safetensors",
        "training.png",
        "summary.json",
    } <= names
    assert any(name.startswith("events.out") for name in names)
    assert run_folder.load_config(finished) == CONFIG
    record = json.loads((finished / "config.json").read_text())
    assert (record["seed"], record["command"]) == (3, "jaxwalk train --seed 3")


def test_metrics_and_summary_agree(finished):
    rows = run_folder.read_metrics(finished)
    reports = [row for row in rows if "train/reward" in row]
    evaluations = [row for row in rows if "eval/score" in row]
    summary = json.loads((finished / "summary.json").read_text())
    assert len(evaluations) >= 2  # before training and after it
    assert [row["footsteps"] for row in reports] == sorted(row["footsteps"] for row in reports)
    assert summary["footsteps"] == reports[-1]["footsteps"] >= CONFIG.train.footsteps
    assert summary["updates"] == reports[-1]["learner/updates"] > 0
    kept = next(row for row in evaluations if row["footsteps"] == summary["best"]["footsteps"])
    assert summary["best"]["score"] == pytest.approx(kept["eval/score"])
    assert not summary["interrupted"]


def test_the_finals_are_between_the_best_evaluations_and_the_first_and_their_winner_is_kept(finished):
    rows = [row for row in run_folder.read_metrics(finished) if "eval/score" in row]
    ranked = sorted(rows, key=lambda row: -row["eval/score"])[: CONFIG.train.finalists]
    summary = json.loads((finished / "summary.json").read_text())
    met = {one["footsteps"] for one in summary["finals"]}
    assert met == {0} | {row["footsteps"] for row in ranked}  # what was learned meets what it began with
    assert summary["best"]["footsteps"] == max(summary["finals"], key=lambda one: one["score"])["footsteps"]


def test_what_a_run_began_with_meets_whoever_was_evaluated_better(finished):
    one = policy.load(finished / "policy.safetensors")
    entered = finals.Finals(CONFIG, devices.mesh(), 0)
    for footsteps, score in ((0, 0.1), (10, 0.5), (20, 0.9), (30, 0.4), (40, 0.7), (50, 0.2)):
        metadata = dataclasses.replace(one.metadata, footsteps=footsteps)
        entered.enter(dataclasses.replace(one, metadata=metadata), score)
    assert entered.entered == [(20, 0.9), (40, 0.7), (10, 0.5), (0, 0.1)]


def test_policies_are_graded_with_late_instruments_on_weak_motors_and_by_second_pushes():
    exam = evaluation.Exam(CONFIG, policy.act, devices.mesh(), 0)
    met, borne = exam.scenarios, exam.scenarios.burden
    assert borne is not None
    late = np.asarray(borne.delay) > 0
    np.testing.assert_array_equal(np.asarray(borne.strength)[late], np.float32(0.8))
    np.testing.assert_array_equal(np.asarray(borne.strength)[~late], 1.0)
    again = np.asarray(met.again)
    assert set(again) == {0, round(1.0 / CONFIG.physics.timestep)}
    assert not (late & (again > 0)).any() and not late[exam.is_calm].any() and not again[exam.is_calm].any()
    for which in (late, again > 0):
        pushed = np.asarray(met.impulse)[which]
        assert (pushed > 0).any() and (pushed < 0).any()


def test_a_score_that_is_not_finite_does_not_take_part(finished):
    entered = finals.Finals(CONFIG, devices.mesh(), 0)
    entered.enter(policy.load(finished / "policy.safetensors"), float("nan"))
    assert entered.settle() == []


def test_a_run_whose_evaluations_are_not_finite_ends_in_one_line(tmp_path, monkeypatch):
    nothing = evaluation.Marks(*[float("nan")] * 5)
    monkeypatch.setattr(evaluation.Exam, "__call__", lambda *_: (nothing, None))
    with pytest.raises(UserError, match=r"no evaluation of the run in .* came to a finite score"):
        run(CONFIG, tmp_path / "run", 3, "jaxwalk train")
    assert not (tmp_path / "run" / "policy.safetensors").exists()


@pytest.mark.slow
def test_without_finals_the_best_evaluation_wins(tmp_path):
    alone = dataclasses.replace(CONFIG, train=dataclasses.replace(CONFIG.train, finalists=1))
    folder = run(alone, tmp_path / "run", 3, "jaxwalk train")
    rows = [row for row in run_folder.read_metrics(folder) if "eval/score" in row]
    summary = run_folder.read_summary(folder)
    assert summary["finals"] == []
    assert summary["best"]["footsteps"] == max(rows, key=lambda row: row["eval/score"])["footsteps"]
    assert policy.load(folder / "policy.safetensors").metadata.footsteps == summary["best"]["footsteps"]


def test_best_policy_is_the_checkpoint_of_its_evaluation(finished):
    best = policy.load(finished / "policy.safetensors")
    same = policy.load(finished / "checkpoints" / f"{best.metadata.footsteps:09d}.safetensors")
    assert best.metadata.score == same.metadata.score
    for a, b in zip(jax.tree.leaves(best), jax.tree.leaves(same), strict=True):
        np.testing.assert_array_equal(a, b)


def test_a_run_is_never_overwritten(finished):
    before = {path: path.stat().st_mtime_ns for path in finished.rglob("*")}
    with pytest.raises(UserError, match="already holds a run"):
        run(CONFIG, finished, 3, "jaxwalk train")
    assert {path: path.stat().st_mtime_ns for path in finished.rglob("*")} == before


def test_interrupt_keeps_the_best_policy(tmp_path, monkeypatch):
    monkeypatch.setattr(Progress, "update", lambda *_: os.kill(os.getpid(), signal.SIGINT))
    before = signal.getsignal(signal.SIGINT)
    folder = run(CONFIG, tmp_path / "b", 3, "jaxwalk train")
    assert signal.getsignal(signal.SIGINT) is before
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["interrupted"]
    assert 0 < summary["footsteps"] < CONFIG.train.footsteps
    policy.load(folder / "policy.safetensors")


def test_window_longer_than_toe_off_is_refused(tmp_path):
    slow = dataclasses.replace(CONFIG, train=dataclasses.replace(CONFIG.train, window_ticks=100))
    with pytest.raises(UserError, match=r"train\.window_ticks"):
        run(slow, tmp_path / "c", 0, "jaxwalk train")
    assert not (tmp_path / "c").exists()


def test_same_seed_same_training_in_one_program(monkeypatch):
    traces = []
    window = collect.window
    monkeypatch.setattr(collect, "window", lambda *args: traces.append(1) or window(*args))
    mesh = devices.mesh()
    advance = device_loop.make.__wrapped__(CONFIG, mesh)  # not one that was traced before

    def train(seed: int):
        state = device_loop.init(CONFIG, mesh, seed)
        for _ in range(3):
            state = advance(state)
        keyless = state.replace(key=None, steppers=None)
        return jax.device_get(keyless)

    first = train(1)
    once = len(traces)
    again, other = train(1), train(2)
    assert first.learner.updates > 0
    jax.tree.map(np.testing.assert_array_equal, first, again)
    kernels = [x.learner.actor["hidden_0"]["kernel"] for x in (first, other)]
    assert not np.array_equal(*kernels)
    assert 0 < len(traces) == once  # six more calls and another seed trace nothing anew


def test_footsteps_are_landings_and_replay_takes_in_every_decision():
    """Steps are decided anew every few windows, and yet a footstep is a footstep, and learnt from as one."""
    mesh, reports = devices.mesh(), 4
    advance, state = device_loop.make(CONFIG, mesh), device_loop.init(CONFIG, mesh, 1)
    made = seconds = falls = 0.0
    for _ in range(reports):
        state = advance(state)
        made += float(state.counts.footsteps)
        seconds += float(state.counts.seconds)
        falls += float(state.counts.falls)
    windows = reports * CONFIG.train.windows_per_report * CONFIG.train.walkers
    # One decision every so many windows, or sooner at a landing; those under way are yet to come.
    often, decided = windows / CONFIG.task.replan, int(jnp.sum(state.replay.size))
    assert CONFIG.task.replan > 1 and often - CONFIG.train.walkers <= decided <= often + made < 2 * decided
    assert float(state.footsteps) == made > CONFIG.ddpg.warmup
    # All that was walked but for the steps under way is of footsteps, each as long as one is.
    lived = windows * CONFIG.train.window_ticks * CONFIG.physics.timestep
    assert lived - CONFIG.train.walkers * CONFIG.gait.stall_seconds < seconds <= lived + 1e-3
    assert seconds > 0.25 * (made - falls)
    assert 0 < int(state.learner.updates) <= CONFIG.ddpg.updates_per_footstep * made


@pytest.mark.slow
def test_walkers_that_the_devices_do_not_divide_train_on_fewer(tmp_path):
    walkers = jax.device_count() * 4 + 1 if jax.device_count() > 1 else 5
    odd = dataclasses.replace(CONFIG, train=dataclasses.replace(CONFIG.train, walkers=walkers))
    folder = run(odd, tmp_path / "d", 0, "jaxwalk train")
    assert json.loads((folder / "summary.json").read_text())["best"]["calm"] >= 0
