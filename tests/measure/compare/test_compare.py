"""``jaxwalk compare`` from the outside, small."""

from __future__ import annotations

import csv
import json
from dataclasses import replace

import jax
import numpy as np
import pytest

from jaxwalk import cli
from jaxwalk.config import DDPGConfig
from jaxwalk.config.presets import PRESETS
from jaxwalk.learn.ddpg import learner
from jaxwalk.learn.policies import named, policy
from jaxwalk.measure.evaluate import evaluation
from jaxwalk.measure.protocol import PushTest

OPTIONS = "--walkers 4 --seconds 6 --impulses -10,10,400 --phases 2 --replicas 1".split()
# Rigid legs, which walk with a step that is never adapted.
FIRST = "shipped-rigid"
CONFIG = replace(PRESETS["rigid"], ddpg=DDPGConfig(hidden=(8,)))
_init = jax.jit(learner.init, static_argnums=(0, 2, 3))


def make_run(folder, config=CONFIG, seed=0, summary=None):
    """A run folder as training leaves it, with an actor that walks nearly the best constant step."""
    folder.mkdir()
    state = _init(config.ddpg, jax.random.key(seed), len(config.observation), (-0.2, -0.6))
    saved = policy.from_learner(config, state, seed=seed, command=f"seed {seed}", footsteps=seed, score=None)
    policy.save(saved, folder / "policy.safetensors")
    if summary is not None:
        (folder / "summary.json").write_text(summary)
    return folder


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    root = tmp_path_factory.mktemp("runs")
    first = make_run(root / "a", seed=0, summary='{"footsteps": 100, "seconds": 7.5}')
    second = make_run(root / "b", seed=1, summary='{"footsteps": 300, "seconds": 8.5}')
    return first, second


@pytest.fixture(scope="module")
def done(runs, tmp_path_factory):
    out = tmp_path_factory.mktemp("compare") / "deep" / "folder"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(evaluation, "AFTER_PUSH", 2.0)
        argv = ["compare", FIRST, f"ddpg={runs[0]},{runs[1]}", "--out", str(out), *OPTIONS]
        assert cli.main(argv) == 0
    return out


def test_everything_is_written(done):
    assert sorted(path.name for path in done.iterdir()) == ["compare.csv", "compare.json", "compare.png"]


def test_seeds_are_kept_and_summed_up(done):
    result = json.loads((done / "compare.json").read_text())
    first, ddpg = result["policies"]
    assert (first["name"], ddpg["name"]) == (FIRST, "ddpg")
    assert len(first["members"]) == 1 and len(ddpg["members"]) == 2
    speeds = [member["figures"]["speed"] for member in ddpg["members"]]
    assert ddpg["spread"]["speed"]["mean"] == pytest.approx(np.mean(speeds))
    assert ddpg["spread"]["training_footsteps"] == pytest.approx(
        {"mean": 200, "sd": 2**0.5 * 100, "min": 100, "max": 300}
    )
    assert first["spread"]["training_seconds"]["mean"] is None
    for policy_ in result["policies"]:
        for member in policy_["members"]:
            assert member["pushes"]["survival"] == [[1, 1], [1, 1], [0, 0]]
            assert member["figures"]["worst_phase_forward"] == 10
    assert result["reach"] == {"forward": 400, "backward": 10}
    # Both survive the 10 N s at which the grid ends backward.
    assert [verdict["kind"] for verdict in result["verdicts"]] == ["undecided"]


def test_the_table_has_a_line_for_each_seed_and_for_their_spread(done):
    with (done / "compare.csv").open() as file:
        lines = list(csv.DictReader(file))
    assert [(line["name"], line["line"].split("/")[-1]) for line in lines] == [
        (FIRST, FIRST), ("ddpg", "a"), ("ddpg", "b"),
        ("ddpg", "mean"), ("ddpg", "sd"), ("ddpg", "min"), ("ddpg", "max"),
    ]  # fmt: skip
    assert lines[0]["training_footsteps"] == ""
    assert float(lines[3]["training_seconds"]) == 8.0
    assert float(lines[5]["speed"]) <= float(lines[3]["speed"]) <= float(lines[6]["speed"])


def test_seeds_of_one_method_share_one_program(runs):
    """Also if they were trained for other rewards; a rule is of another kind."""
    first, second = (named.load(str(run)) for run in runs)
    other = replace(second, config=replace(second.config, ddpg=replace(CONFIG.ddpg, gamma=0.5)))
    programs = evaluation.Programs(PushTest())
    assert programs.of(first) is programs.of(second) is programs.of(other)
    assert jax.tree.structure(first.params) == jax.tree.structure(second.params)
    assert programs.of(named.load("fixed")) is not programs.of(first)
    rules = [programs.of(named.load(name)) for name in ("constant", "raibert", "capture-point")]
    assert rules[0] is rules[1] is rules[2] is not programs.of(first)


def test_another_world_is_refused_and_named(runs, tmp_path, capsys):
    slippery = make_run(tmp_path / "ice", replace(CONFIG, physics=replace(CONFIG.physics, friction=0.2)))
    out = tmp_path / "out"
    assert cli.main(["compare", FIRST, str(runs[0]), str(slippery), "--out", str(out), *OPTIONS]) == 2
    error = capsys.readouterr().err
    assert f"{FIRST} and {slippery} differ in physics.friction: 0.9 and 0.2" in error
    assert error.count("\n") == 1 and not out.exists()


def test_other_controllers_are_told(runs):
    from jaxwalk.measure.compare import groups, policies

    loaded = policies.load(groups.parse([FIRST, str(runs[0])]))
    assert policies.controllers_differ(loaded) == []
    stiff = replace(CONFIG, gait=replace(CONFIG.gait, swing_knee=1.2))
    changed = replace(loaded[1][0], subject=replace(loaded[1][0].subject, config=stiff))
    told = policies.controllers_differ([loaded[0], [changed]])
    assert told == [f"{runs[0]} walks with gait.swing_knee 1.2, {FIRST} with 1.4"]


@pytest.mark.parametrize(
    ("summary", "said"),
    [
        ("{", "summary.json: not JSON"),
        ("[1]", "summary.json holds no summary"),
        ('{"footsteps": "many"}', "footsteps is 'many', not a number"),
    ],
)
def test_a_damaged_run_folder_is_one_line(summary, said, tmp_path, capsys):
    run = make_run(tmp_path / "run", summary=summary)
    assert cli.main(["compare", FIRST, str(run), "--out", str(tmp_path / "out"), *OPTIONS]) == 2
    error = capsys.readouterr().err
    assert said in error and error.count("\n") == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("argv", "said"),
    [
        (["fixed", "no/such/run"], "no policy 'no/such/run'"),
        (["fixed", "ddpg=fixed,no/such/run"], "no policy 'no/such/run'"),
        (["fixed", "fixed"], "'fixed' is given twice"),
        (["fixed", "--impulses", "30,20"], "--impulses 30,20: give ascending"),
        (["fixed", "--impulses", "0,20"], "--impulses 0: give -1000 to 1000 N s"),
        (["fixed", "--phases", "0"], "--phases 0"),
        ([], "nothing to compare"),
    ],
)
def test_bad_options_are_one_line(argv, said, tmp_path, capsys):
    assert cli.main(["compare", *argv, "--out", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert said in error and error.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_an_empty_run_folder_is_one_line(tmp_path, capsys):
    (tmp_path / "empty").mkdir()
    assert cli.main(["compare", "fixed", str(tmp_path / "empty"), "--out", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert "No such file" in error and error.count("\n") == 1
