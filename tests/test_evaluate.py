"""``jaxwalk evaluate`` from the outside."""

from __future__ import annotations

import json

import numpy as np
import pytest

from jaxwalk import cli


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    file = tmp_path_factory.mktemp("evaluate") / "fixed.json"
    options = "--walkers 8 --seconds 8 --impulses -10,10,400 --phases 2 --replicas 1".split()
    assert cli.main(["evaluate", "fixed", *options, "--json", str(file)]) == 0
    return json.loads(file.read_text())


def test_default_step_walks(result):
    walking = result["walking"]
    assert walking["survival"] == 1.0
    assert walking["speed_mean"] == pytest.approx(1.0, abs=0.1)
    # speed = length x cadence: three figures that are counted apart
    steps = walking["step_length_mean"] / walking["step_duration_mean"]
    assert walking["speed_mean"] == pytest.approx(steps, abs=0.05)
    assert walking["torso_pitch_amplitude"] < 0.1  # the paper's bound


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
