"""Which settings are tried, that only they change, and what ``jaxwalk sensitivity`` writes."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest
from PIL import Image

from jaxwalk import cli
from jaxwalk.common.errors import UserError
from jaxwalk.config import Config, SensorConfig
from jaxwalk.control import sensors
from jaxwalk.measure.evaluate import evaluation
from jaxwalk.measure.sensitivity.settings import PARAMETERS, at_timestep, settings

NONE = dict.fromkeys(PARAMETERS, ())


def test_each_setting_is_changed_alone_and_the_own_one_is_among_them():
    found = settings(Config(), NONE | {"friction": (1.2, 0.5), "iterations": (8.0,)})
    told = [(one.parameter, one.value, one.own) for one in found]
    assert told == [
        ("timestep", 0.002, True),
        ("iterations", 3, True), ("iterations", 8, False),
        ("contact_timeconst", 0.015, True),
        ("friction", 0.5, False), ("friction", 0.9, True), ("friction", 1.2, False),
    ]  # fmt: skip
    for one in found:
        physics = dataclasses.replace(Config().physics, **{one.parameter: one.value})
        assert one.config == dataclasses.replace(Config(), physics=physics)
    assert [type(one.value) for one in found[:2]] == [float, int]


@pytest.mark.parametrize(("timestep", "ticks"), [(0.001, 20), (0.0025, 8), (0.004, 5)])
def test_what_is_in_seconds_stays_when_the_tick_changes(timestep, ticks):
    before, after = Config(), at_timestep(Config(), timestep)
    assert (after.physics.timestep, after.train.window_ticks) == (timestep, ticks)
    assert after.sensors.mean_window * timestep == pytest.approx(0.02)
    # White noise of one density: the mean of all readings within a second is equally wrong.
    for name in ("velocity_std", "gyro_std", "touch_std"):
        densities = [getattr(c.sensors, name) ** 2 * c.physics.timestep for c in (before, after)]
        assert densities[0] == pytest.approx(densities[1])
    # The filter forgets at the same rate: exp(-rate x timestep) is what a reading's error leaves behind.
    rates = []
    for config in (before, after):
        dt, gain = config.physics.timestep, sensors.kalman_gain(config.sensors, config.physics.timestep)
        left = (np.eye(2) - gain) @ np.array([[1.0, dt], [0.0, 1.0]])
        rates.append(sorted(-np.log(np.abs(np.linalg.eigvals(left))) / dt))
    # The discrete filter approaches the continuous one with the tick: some 10 % at these.
    np.testing.assert_allclose(rates[0], rates[1], rtol=0.15)


def test_its_own_tick_changes_nothing():
    config = Config(sensors=SensorConfig(noise=0.5))
    assert at_timestep(config, 0.002) == config


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"timestep": (0.003,)}, "--timesteps 0.003: the decision window, 0.02 s, is no whole number"),
        ({"timestep": (0.04,)}, "--timesteps 0.04: the decision window"),
        ({"timestep": (0.01,)}, "--timesteps 0.01: --physics.contact-timeconst 0.015: give at least two"),
        ({"contact_timeconst": (0.003,)}, "--contact-timeconsts 0.003: --physics.contact-timeconst 0.003"),
    ],
)
def test_what_cannot_be_simulated_is_refused(values, said):
    with pytest.raises(UserError) as caught:
        settings(Config(), NONE | values)
    assert str(caught.value).startswith(said)


@pytest.mark.parametrize(("engine", "iterations"), [("mjx", 3), ("mujoco", 0)])
def test_the_command_measures_each_setting_once(monkeypatch, tmp_path, capsys, engine, iterations):
    asked = []

    def canned(subject, args):
        asked.append((subject.config, args))
        walking = {
            "survival": 0.5, "speed_mean": 1.0, "speed_std": 0.1,
            "step_length_mean": 0.4, "step_duration_mean": 0.4,
        }  # fmt: skip
        last = 1.0 if subject.config.physics.friction > 1 else 0.0
        pushes = {"survival": [[1.0, last]], "impulses": [40.0]}
        return {"walking": walking, "pushes": pushes, "threshold": {"forward": 40.0, "backward": None}}

    monkeypatch.setattr(evaluation, "evaluate", canned)
    out = tmp_path / "s"
    options = "--walkers 8 --replicas 2 --impulses 40 --phases 2 --seed 4".split()
    assert cli.main(["sensitivity", "fixed", "--out", str(out), "--engine", engine, *options]) == 0
    # The own configuration once for all four; 2 time steps, 3 contacts and 3 frictions more, and
    # 3 iterations where they count.
    assert len(asked) == len({config for config, _ in asked}) == 1 + 2 + iterations + 3 + 3
    assert {(args.engine, args.seed, args.replicas) for _, args in asked} == {(engine, 4, 2)}
    result = json.loads((out / "sensitivity.json").read_text())
    assert sum(row["own"] for row in result["rows"]) == len(PARAMETERS)
    last = result["rows"][-1]
    assert (last["parameter"], last["value"], last["pushes_survived"]["survivors"]) == ("friction", 1.2, 4)
    assert result["rows"][0]["pushes_survived"]["survivors"] == 2
    assert result["rows"][0]["never_fell"] == result["rows"][1]["never_fell"]
    assert result["rows"][0]["never_fell"]["survivors"] == 4
    assert "friction 0.9*" in capsys.readouterr().out
    with Image.open(out / "sensitivity.png") as image:
        assert len(np.unique(np.asarray(image.convert("RGB")).reshape(-1, 3), axis=0)) > 50


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--frictions", "0"], "--frictions 0: give a number"),
        (["--iterations", "2.5"], "--iterations 2.5: give whole numbers"),
        (["--engine", "bullet"], "'bullet'"),
        (["--timesteps", "0.003"], "--timesteps 0.003: the decision window"),
    ],
)
def test_bad_options_are_one_line(options, said, tmp_path, capsys):
    assert cli.main(["sensitivity", "fixed", "--out", str(tmp_path / "s"), *options]) == 2
    error = capsys.readouterr().err
    assert said in error and error.count("\n") == 1
    assert not (tmp_path / "s").exists()
