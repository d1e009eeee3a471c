"""Refining: the last layer alone is searched, and what is no better is not kept."""

from __future__ import annotations

import cmaes
import jax
import numpy as np
import pytest

from jaxwalk import cli
from jaxwalk.learn import evolution
from jaxwalk.learn.policies import named, policy
from jaxwalk.learn.refine import search
from jaxwalk.learn.train.evaluation import Marks
from jaxwalk.task import scenarios

GOAL = 0.3  # of the biases of the last layer


class Graded:
    """Instead of walkers: the nearer a policy's last biases are to `GOAL`, the better."""

    drawn: list[int]

    def __init__(self, *asked, replicas=None):
        self.drawn, self.asked, self.replicas = [], asked, replicas

    def renew(self, seed):
        self.drawn.append(seed)

    def __call__(self, asked):
        score = 1.0 - float(np.sum((np.asarray(asked.actor["output"]["bias"]) - GOAL) ** 2))
        return Marks(score, 0.5, 0.5, 1.0, 1.0), None


@pytest.fixture
def graded(monkeypatch):
    made = []

    def exam(*args, **more):
        made.append(Graded(*args, **more))
        return made[-1]

    monkeypatch.setattr(search, "Exam", exam)
    monkeypatch.setattr(search.finals, "examination", exam)
    return made


@pytest.fixture(scope="module")
def given():
    return policy.load(named.file("shipped"))


def refined(given, generations=40, candidates=8, tell=lambda generation, score: False):
    return search.run(named.load("shipped").config, given, 5, generations, candidates, 0.05, tell)


def test_the_search_finds_what_is_better_in_the_last_layer_alone(graded, given):
    found = refined(given)
    # Of the way to the goal half is gone: a quarter is left of what both biases lacked, squared.
    lacked = 1.0 - found.before.score
    assert found.better and found.after.score == pytest.approx(1.0 - lacked / 4, abs=0.01)
    for name, layer in given.actor.items():
        same = jax.tree.map(np.array_equal, layer, found.policy.actor[name])
        assert all(jax.tree.leaves(same)) == (name != "output"), name
    assert found.policy.metadata == given.metadata
    np.testing.assert_array_equal(found.policy.observation_std, given.observation_std)


def test_every_generation_meets_pushes_of_its_own(graded, given):
    refined(given, generations=3)
    assert graded[0].drawn == [6, 7, 8]


def test_it_is_held_against_pushes_that_nobody_chose_by(graded, given):
    """Training's finals have the same seeds: the policy that is given may be the luckiest there."""
    refined(given, generations=1)
    searched, held = graded
    assert scenarios.TUNE in searched.asked and scenarios.REFINED in held.asked
    assert searched.replicas == 1


def test_scores_that_are_no_numbers_lose():
    """By one less than the worst."""

    class Search(cmaes.SepCMA):
        def __init__(self):
            self.told = []

        def tell(self, told):
            self.told = told

    one = Search()
    evolution.tell(one, [np.zeros(1)] * 3, np.array([float("nan"), 0.25, -20.0]))
    assert [float(score) for _, score in one.told] == [21.0, -0.25, 20.0]  # it minimises


def test_the_search_ends_when_it_is_told_to(graded, given):
    refined(given, tell=lambda generation, score: generation == 2)
    assert len(graded[0].drawn) == 2


def test_the_command_keeps_the_line_that_made_the_policy(graded, given, tmp_path, capsys):
    out = tmp_path / "refined.safetensors"
    line = f"refine shipped --out {out} --generations 30 --candidates 8 --sigma 0.1".split()
    assert cli.main(line) == 0
    assert "the one that was found" in capsys.readouterr().out
    kept = policy.load(out).metadata
    assert kept.command == f"{given.metadata.command}; jaxwalk {' '.join(line)}"
    assert kept.footsteps == given.metadata.footsteps


def test_what_is_no_better_is_not_kept(graded, given, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(search.finals, "examination", lambda *_: lambda asked: (Marks(0.5, 0, 0, 0, 0), None))
    out = tmp_path / "same.safetensors"
    assert cli.main(["refine", "shipped", "--out", str(out), "--generations", "1"]) == 0
    assert "the one that was given" in capsys.readouterr().out
    kept = policy.load(out)
    assert kept.metadata == given.metadata
    np.testing.assert_array_equal(kept.actor["output"]["kernel"], given.actor["output"]["kernel"])


def test_a_rule_is_refused(tmp_path, capsys):
    assert cli.main(["refine", "replan", "--out", str(tmp_path / "x.safetensors")]) == 2
    assert "is a rule, not trained" in capsys.readouterr().err
