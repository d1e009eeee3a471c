"""The rules on numbers made by hand: each claim can hold, not hold, and be left open."""

from __future__ import annotations

import numpy as np
import pytest
from paper import canned

from jaxwalk.paper import verdict as v
from jaxwalk.paper.claims import registry
from jaxwalk.paper.options import NAMES
from jaxwalk.paper.page import ours


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("verdict", canned.ANSWERS)
def test_each_claim_reaches_each_verdict(name, verdict):
    claim = registry()[name]
    numbers = canned.NUMBERS[name](canned.ANSWERS[verdict])
    assert v.verdict(claim.checks(numbers)) == verdict


@pytest.mark.parametrize("name", ["state", "rates", "start"])
def test_without_trainings_nothing_is_told(name):
    claim = registry()[name]
    checks = claim.checks({"missing": ["policies/full-0.safetensors", "curves/full-0.csv"]})
    assert v.verdict(checks) == v.OPEN and "policies/full-0.safetensors and 1 more" in checks[0].says


def test_one_body_that_says_no_decides_and_one_that_cannot_tell_leaves_it_open():
    claim, (good, bad, unsure) = registry()["pitch"], (canned.pitch(1), canned.pitch(-1), canned.pitch(0))
    for walls, verdict in ((good, v.HOLDS), (bad, v.FAILS), (unsure, v.OPEN)):
        each, both = ours(claim, {"planar": good, "walls": walls})
        assert both == verdict and [one.verdict for one in each] == [v.HOLDS, verdict]


def test_a_no_outweighs_what_is_open():
    answers = [v.Check("", True), v.Check("", None), v.Check("", False)]
    assert v.verdict(answers) == v.FAILS and v.verdict(answers[:2]) == v.OPEN
    assert v.verdict(answers[:1]) == v.HOLDS and v.verdict([]) == v.OPEN


def test_intervals_are_those_of_the_textbook():
    # Student's: 1, 2, 3 have mean 2 and half-width 4.303 x 1 / sqrt(3).
    mean = v.mean_of([1.0, 2.0, 3.0, float("nan")])
    assert (mean["mean"], mean["n"]) == (2.0, 3) and mean["high"] == pytest.approx(2 + 2.4841, abs=1e-3)
    assert v.above(v.mean_of([5.0])) is None and v.above(v.mean_of([])) is None
    # Newcombe 1998, table II (a): 56 of 70 less 48 of 80 is 0.0524 to 0.3339.
    apart = v.difference(v.share(np.arange(70) < 56), v.share(np.arange(80) < 48))
    assert (apart["low"], apart["high"]) == (pytest.approx(0.0524, abs=1e-4), pytest.approx(0.3339, abs=1e-4))
    # A slope of 2 without noise; noise about a slope of 0.
    assert v.slope(np.arange(4), np.arange(1, 8, 2))["low"] == pytest.approx(2.0)
    rng = np.random.default_rng(0)
    flat = v.slope(np.arange(200), rng.normal(size=200))
    assert flat["low"] < 0 < flat["high"]
    assert v.slope(np.ones(3), np.arange(3))["mean"] is None


def test_a_bar_is_passed_only_by_the_whole_interval():
    for interval, answer in (
        (canned.about(1, 0.5), True),
        (canned.about(0.3, 0.5), None),
        (canned.about(-1, 0.5), False),
    ):
        assert v.above(interval) is answer
        assert v.below(interval) is (None if answer is None else not answer)
    assert v.within(canned.about(1, 0.05), 0.9, 1.1) is True
    assert v.within(canned.about(1.1, 0.05), 0.9, 1.1) is None
    assert v.within(canned.about(1.3, 0.05), 0.9, 1.1) is False


@pytest.mark.parametrize("name", NAMES)
def test_what_a_claim_says_and_by_which_rule_is_told(name):
    claim = registry()[name]
    assert (
        claim.name == name and claim.says.endswith((".", "”", ".”")) and "95 %" in claim.rule and claim.where
    )
    assert set(claim.quick) <= set(claim.bodies) and claim.bodies


@pytest.mark.parametrize("name", ["state", "rates", "start"])
def test_without_trainings_there_is_no_figure_and_no_row(name):
    claim, numbers = registry()[name], {"missing": ["policies/full-0.safetensors"]}
    assert claim.draw is not None and claim.draw({"planar": numbers}) is None and claim.table(numbers) == []
