"""The evolution strategy: where it begins, what candidates are judged by, what it leaves behind."""

from __future__ import annotations

import dataclasses
import json
import shutil
import sys
from pathlib import Path

import jax
import numpy as np
import pytest
from jax.flatten_util import ravel_pytree

sys.path.append(str(Path(__file__).parent))

import small

from jaxwalk import cli
from jaxwalk.common.parallel import devices
from jaxwalk.config import ESConfig, PushConfig
from jaxwalk.learn.policies import named, policy
from jaxwalk.learn.runs import run_folder
from jaxwalk.learn.train import beside
from jaxwalk.learn.train.es import population, run

CONFIG = dataclasses.replace(
    small.CONFIG,
    ddpg=dataclasses.replace(small.CONFIG.ddpg, hidden=(4,)),
    es=ESConfig(generations=2, candidates=4, walkers=4, seconds=1.0),
    pushes=PushConfig(rate=0.0),
    train=dataclasses.replace(small.CONFIG.train, walkers=4, evaluations=2, finalists=1),
)


@pytest.fixture(scope="module", autouse=True)
def short():
    with pytest.MonkeyPatch.context() as patch:
        small.shorten(patch.setattr)
        patch.setattr(population, "SEEN_SECONDS", 0.5)
        yield


@pytest.fixture(scope="module")
def kind():
    return population.shape(CONFIG, seed=3)  # that of `finished`: one program


@pytest.fixture(scope="module")
def earn(kind):
    return population.earning(CONFIG, kind, devices.mesh(CONFIG.es.candidates))


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    return run.run(CONFIG, tmp_path_factory.mktemp("es") / "a", 3, "jaxwalk train --learner es")


def test_it_begins_with_the_plan_left_as_it_is(kind):
    seen = jax.random.normal(jax.random.key(0), (20, len(CONFIG.observation)))
    assert not np.any(jax.vmap(lambda o: kind.act(kind.first, o))(seen))


def test_candidates_that_are_alike_earn_alike_and_others_do_not(kind, earn):
    # The last numbers are the output's: one is told to take shorter steps, whatever it sees.
    leaves = kind.unravel(np.asarray(kind.first))
    shorter = {**leaves, "output": {**leaves["output"], "bias": np.array([-2.0, 0.0], np.float32)}}
    other = ravel_pytree(shorter)[0]
    told = earn(np.stack([kind.first, kind.first, other, kind.first]), jax.random.key(1))
    assert told[0].tolist() == told[1].tolist() == told[3].tolist()
    assert told[2, 0] != told[0, 0]
    # Who walks in peace for a second earns nearly 1 for each nominal step, less its work's price, and takes
    # one or two.
    assert 0.3 < told[0, 0] < 1.1 and 4 <= told[0, 1] <= 4 * 3


def test_what_it_leaves_is_a_run_folder(finished):
    summary, rows = run_folder.read_summary(finished), run_folder.read_metrics(finished)
    assert summary["algorithm"] == "es" and summary["settings"] == dataclasses.asdict(CONFIG.es)
    made = [row["footsteps"] for row in rows]
    assert len(made) == 3 and made[0] == 0 and sorted(set(made)) == made
    assert all(np.isfinite(row["eval/score"]) for row in rows)
    kept = policy.load(finished / run_folder.POLICY)
    assert kept.metadata.footsteps in made and kept.metadata.hidden == (4,)
    assert named.load(str(finished)).config == CONFIG
    assert json.loads((finished / "config.json").read_text())["command"] == "jaxwalk train --learner es"


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ("--es.candidates 3", "--es.candidates 3: give 4 to"),
        ("--es.seconds 0", "--es.seconds 0.0: give a number above 0"),
        ("--seeds 2", "--learner es: one seed in one process"),
    ],
)
def test_what_cannot_be_meant_is_said_in_a_line(options, says, capsys):
    assert cli.main(["train", "--learner", "es", *options.split()]) == 2
    assert says in capsys.readouterr().err


def test_it_is_not_resumed(finished, capsys):
    assert cli.main(["train", "--resume", str(finished)]) == 2
    assert "evolution strategy's, which nobody goes on with" in capsys.readouterr().err


def test_one_that_was_stopped_is_not_said_to_go_on(finished, tmp_path):
    stopped = shutil.copytree(finished, tmp_path / "stopped")
    told = run_folder.read_summary(finished) | {"interrupted": True}
    (stopped / run_folder.SUMMARY).write_text(json.dumps(told))
    assert not any("--resume" in line for line in beside.lines(stopped))
