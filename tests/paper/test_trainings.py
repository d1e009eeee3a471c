"""The trainings that the claims compare: their commands, and what is kept of a run."""

from __future__ import annotations

import dataclasses
import json
import shlex
from pathlib import Path

import pytest

from jaxwalk.common import files, resources
from jaxwalk.common.errors import UserError
from jaxwalk.config import to_dict
from jaxwalk.learn.policies import policy
from jaxwalk.learn.runs import run_folder
from jaxwalk.learn.train import command, options
from jaxwalk.paper import trainings
from jaxwalk.paper.claims import registry
from jaxwalk.paper.lab import Lab
from jaxwalk.paper.trainings import TRAININGS


def test_each_command_is_one_that_train_understands_and_they_differ():
    configs = {name: options.read(shlex.split(one.line(0))[2:]).config for name, one in TRAININGS.items()}
    assert len({json.dumps(to_dict(config)) for config in configs.values()}) == len(TRAININGS) == 5
    full = configs["full"]
    assert full.observation == ("speed", "pitch", "zmp", "step_length") and full.train.footsteps == 250_000
    assert configs["pair"].observation == ("zmp", "pitch")
    assert (configs["printed"].ddpg.actor_lr, configs["printed"].ddpg.critic_lr) == (1e-8, 2e-8)
    assert (full.ddpg.start, configs["random"].ddpg.start) == ("nominal", "random")
    assert configs["walls"].body.model == "walls"


def a_run(path, name="full", seed=1, **changes):
    """A finished run folder, but for what nobody looks at; its policy is the shipped one."""
    words = [*TRAININGS[name].words_of(seed), "--run-dir", str(path)]
    config = to_dict(options.read(TRAININGS[name].words_of(seed)[1:]).config)
    record = {
        "config": config,
        "seed": seed,
        "command": shlex.join(["jaxwalk", *words]),
        "versions": {},
    } | changes
    path.mkdir()
    files.write_json(path / run_folder.CONFIG, record)
    rows = [
        {"footsteps": 2000, "train/reward": 0.5},
        {"footsteps": 2000, "eval/survival": 0.25, "eval/score": -0.5},
        {"footsteps": 4000, "eval/survival": 0.75, "eval/score": 0.5},
    ]
    (path / run_folder.METRICS).write_text("".join(json.dumps(row) + "\n" for row in rows))
    loaded = policy.load(resources.model_path("shipped.safetensors"))
    policy.save(loaded, path / run_folder.POLICY)
    files.write_json(path / run_folder.SUMMARY, {"interrupted": False})
    return path


def test_of_a_run_its_policy_and_its_curve_are_kept_with_the_command(tmp_path):
    run, folder = a_run(tmp_path / "run"), tmp_path / "kept"
    assert trainings.missing(folder, "full") == [
        f"{kind}/full-{seed}.{ending}"
        for seed in (0, 1, 2)
        for kind, ending in (("policies", "safetensors"), ("curves", "csv"))
    ]
    before = trainings.digest(folder, ("full",))
    trainings.keep(run, "full", 1, folder)
    assert trainings.curve(folder, "full", 1) == trainings.Curve((2000, 4000), (0.25, 0.75), (-0.5, 0.5))
    kept = policy.load(trainings.policy_file(folder, "full", 1)).metadata
    assert kept.command == TRAININGS["full"].line(1)  # where the run lay is nobody's business
    first = trainings.curve_file(folder, "full", 1).read_text().splitlines()[0]
    assert first == f"# {TRAININGS['full'].line(1)}"
    assert "policies/full-1.safetensors" not in trainings.missing(folder, "full")
    assert trainings.digest(folder, ("full",)) != before


@pytest.mark.parametrize(
    ("changes", "name", "seed", "says"),
    [
        ({}, "mood", 1, "no training 'mood' of seed 1: give one of full (0, 1, 2)"),
        ({}, "full", 7, "no training 'full' of seed 7"),
        ({}, "full", 2, "has seed 1, not 2"),
        (
            {},
            "pair",
            1,
            "has another configuration: give one of jaxwalk train --preset quick --observation zmp",
        ),
        ({"config": {}}, "full", 1, "has another configuration"),
    ],
)
def test_a_run_of_something_else_is_not_kept(tmp_path, changes, name, seed, says):
    run, folder = a_run(tmp_path / "run", **changes), tmp_path / "kept"
    with pytest.raises(UserError) as error:
        trainings.keep(run, name, seed, folder)
    assert says in str(error.value) and not folder.exists()


@pytest.mark.parametrize(
    ("file", "content"),
    [
        (run_folder.METRICS, '{"footsteps": 1}\n'),
        (run_folder.SUMMARY, '{"interrupted": true}'),
        (run_folder.SUMMARY, None),
    ],
)
def test_a_run_that_is_not_over_is_not_kept(tmp_path, file, content):
    run = a_run(tmp_path / "run")
    (run / file).unlink()
    if content is not None:
        (run / file).write_text(content)
    with pytest.raises(UserError, match="is not over"):
        trainings.keep(run, "full", 1, tmp_path / "kept")


def test_all_runs_are_trained_one_after_another_and_what_was_stopped_goes_on(tmp_path, monkeypatch):
    asked, stop = [], {"random-1"}

    def trained(args, typed):
        argv = shlex.split(typed)[2:]
        asked.append(argv)
        resumed = argv[0] == "--resume"
        run = Path(argv[argv.index("--resume" if resumed else "--run-dir") + 1])
        name, seed = run.name.rsplit("-", 1)
        if not resumed:
            a_run(run, name, int(seed))
        interrupted = run.name in stop and not resumed
        files.write_json(run / run_folder.SUMMARY, {"interrupted": interrupted})

    (tmp_path / "runs").mkdir()
    monkeypatch.setattr(command, "main", trained)
    said = []
    everything = (tmp_path, tmp_path / "runs", ("random", "walls"), said.append)
    with pytest.raises(KeyboardInterrupt):
        trainings.train(*everything)
    assert trainings.missing(tmp_path, "random") == [
        f"{kind}-{seed}.{ending}"
        for seed in (1, 2)
        for kind, ending in (("policies/random", "safetensors"), ("curves/random", "csv"))
    ]
    trainings.train(*everything)
    assert trainings.missing(tmp_path, "random") == trainings.missing(tmp_path, "walls") == []
    assert [argv[0] for argv in asked] == ["--preset", "--preset", "--resume", "--preset", "--preset"]
    assert said[0] == TRAININGS["random"].line(0) and "--ddpg.start random" in said[0]


@pytest.mark.parametrize(
    "content", ["", "footsteps,survival\n1,2\n", "footsteps,survival,score\n1,2,nan\n", "\0"]
)
def test_a_damaged_curve_is_one_line(tmp_path, content):
    path = trainings.curve_file(tmp_path, "full", 0)
    path.parent.mkdir()
    path.write_text(content)
    with pytest.raises(UserError, match="holds no learning curve"):
        trainings.curve(tmp_path, "full", 0)


@pytest.mark.slow
def test_a_training_of_seconds_gives_files_that_the_claims_read(tmp_path, monkeypatch):
    monkeypatch.setitem(TRAININGS, "full", dataclasses.replace(TRAININGS["full"], seeds=(0,)))
    said = []
    trainings.train(tmp_path, tmp_path / "runs", ("full",), said.append, preset="smoke")
    assert said == ["jaxwalk train --preset smoke --observation speed pitch zmp step_length --seed 0"]
    assert trainings.missing(tmp_path, "full") == []
    assert trainings.curve(tmp_path, "full", 0).footsteps
    said.clear()
    trainings.train(tmp_path, tmp_path / "runs", ("full",), said.append, preset="smoke")
    assert said == []  # what is finished is not trained again


def test_policies_are_examined_once_for_all_claims_that_compare_them(tmp_path, monkeypatch):
    for name in ("full", "pair", "printed"):
        for seed in TRAININGS[name].seeds:
            trainings.keep(a_run(tmp_path / f"{name}-{seed}", name, seed), name, seed, tmp_path)
    examined = []

    def exam(self, subject, model, numbers=None, what="exam"):
        examined.append(subject.name)
        told = {"mean": 0.5, "low": 0.4, "high": 0.6, "n": 64}
        return {"calm": told, "pushed": told, "speed": told, "speeds": [], "survived": [], "impulses": []}

    monkeypatch.setattr(Lab, "exam", exam)
    lab = Lab("fixed", tmp_path, True, 0)
    for name in ("state", "rates"):
        numbers = registry()[name].measure(lab, "planar")
        assert [one["seed"] for one in numbers["runs"]["full"]] == [0, 1, 2]
        assert numbers["runs"]["full"][0]["curve"]["survival"] == (0.25, 0.75)
    assert len(examined) == len(set(examined)) == 3 + 3 + 3 + 1
    # Of the third claim some are lacking.
    assert registry()["start"].measure(lab, "planar") == {"missing": trainings.missing(tmp_path, "random")}
