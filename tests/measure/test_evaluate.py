"""``jaxwalk evaluate`` from the outside."""

from __future__ import annotations

import json

import numpy as np
import pytest

from jaxwalk import cli
from jaxwalk.common.parallel import devices
from jaxwalk.measure.evaluate import evaluation

ENGINES = ("mjx", "mujoco")


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """By engine."""
    found = {}
    options = "--walkers 8 --seconds 8 --impulses -10,10,400 --phases 2 --replicas 1".split()
    with pytest.MonkeyPatch.context() as patch:
        # C MuJoCo, called tick by tick, is slow: nobody walks who, nor when nothing, is looked at.
        patch.setattr(devices, "BLOCK", 8)
        patch.setattr(evaluation, "BEFORE_PUSH", 4.0)
        patch.setattr(evaluation, "AFTER_PUSH", 4.0)
        for engine in ENGINES:
            file = tmp_path_factory.mktemp("evaluate") / "replan.json"
            assert cli.main(["evaluate", "replan", *options, "--engine", engine, "--json", str(file)]) == 0
            found[engine] = json.loads(file.read_text())
    return found


@pytest.fixture(params=ENGINES)
def result(results, request):
    return results[request.param]


def test_default_step_walks(result):
    walking = result["walking"]
    assert walking["survival"] == 1.0
    assert walking["speed_mean"] == pytest.approx(1.0, abs=0.1)
    # speed = length x cadence: three figures that are counted apart
    steps = walking["step_length_mean"] / walking["step_duration_mean"]
    assert walking["speed_mean"] == pytest.approx(steps, abs=0.05)
    assert walking["torso_pitch_amplitude"] < 0.1  # the paper's bound


def test_both_engines_see_the_same_walk(results):
    mjx, mujoco = (results[engine]["walking"] for engine in ENGINES)
    # Same starts and noise. Paths part after some steps (a contact a tick early or late), so that means over
    # 8 walkers and 5 s are alike, not the same: a walker's speed spreads by some 0.02 m/s, its steps by 5 %.
    assert mjx["speed_mean"] == pytest.approx(mujoco["speed_mean"], abs=0.02)
    assert mjx["step_length_mean"] == pytest.approx(mujoco["step_length_mean"], rel=0.03)
    assert mjx["step_duration_mean"] == pytest.approx(mujoco["step_duration_mean"], rel=0.03)
    assert mjx["torso_pitch_mean"] == pytest.approx(mujoco["torso_pitch_mean"], abs=0.01)
    assert mjx != mujoco
    assert [results[engine]["options"]["engine"] for engine in ENGINES] == list(ENGINES)


def test_pushes_have_the_contract_s_shape(result):
    pushes = result["pushes"]
    assert pushes["impulses"] == [-10.0, 10.0, 400.0]
    assert pushes["phases"] == [0.0, 0.5]
    assert np.shape(pushes["survival"]) == np.shape(pushes["recovery_seconds"]) == (3, 2)


def test_impulses_are_delivered(result):
    # Sums of 50 float32 terms: 1e-5 of the impulse.
    np.testing.assert_allclose(result["pushes"]["impulse_delivered"][:2], [-10, 10], rtol=1e-5)


def test_small_pushes_are_survived_and_recovered_and_huge_ones_are_not(result):
    survival, recovery = result["pushes"]["survival"], result["pushes"]["recovery_seconds"]
    assert survival[:2] == [[1.0, 1.0], [1.0, 1.0]]
    assert all(x is not None and x < 5.0 for row in recovery[:2] for x in row)
    assert survival[2] == [0.0, 0.0]  # 5 m/s
    assert recovery[2] == [None, None]
    assert result["threshold"] == {"forward": 10.0, "backward": 10.0}


def test_configuration_is_told(result):
    assert result["config"]["body"]["height"] == 1.8
