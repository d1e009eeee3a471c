"""Which circumstances are tried, that each changes one thing, and what ``jaxwalk generalise`` writes."""

from __future__ import annotations

import csv
import dataclasses
import json

import numpy as np
import pytest
from PIL import Image

from jaxwalk import cli
from jaxwalk.config import BodyConfig, Config
from jaxwalk.config.presets import PRESETS
from jaxwalk.measure.evaluate import evaluation
from jaxwalk.measure.generalise.circumstances import circumstances
from jaxwalk.measure.generalise.options import KINDS
from jaxwalk.model.burdens import Burden
from jaxwalk.task import trials

NOTHING = Burden(0.0, 0.20, 0.0, 0.0, 0.9)


def test_each_circumstance_changes_one_thing_and_the_own_one_is_among_them():
    found = circumstances(Config(), dict.fromkeys(KINDS, (2.0,)))
    own = [one for one in found if one.own]
    assert len(found) == 2 * len(own) == 2 * len(KINDS)
    usual = {"speed": 1.0, "height": 1.8, "mass": 75.0, "noise": 1.0, "burden": NOTHING}
    for one in own:
        assert {name: getattr(one, name) for name in usual} == usual
    changed = {
        one.kind: {name: getattr(one, name) for name in usual if getattr(one, name) != usual[name]}
        for one in found
        if not one.own
    }
    assert changed == {
        "stature": {"height": 2.0, "mass": pytest.approx(75 * (2 / 1.8) ** 3)},
        "mass": {"mass": 2.0},
        "backpack": {"burden": Burden(2.0, -0.18, 0.10, 0.0, 0.9)},
        "front_pack": {"burden": Burden(2.0, 0.20, 0.0, 0.0, 0.9)},
        "force": {"burden": dataclasses.replace(NOTHING, force=2.0)},
        "friction": {"burden": dataclasses.replace(NOTHING, friction=2.0)},
        "slope": {"burden": dataclasses.replace(NOTHING, slope=np.radians(2.0))},
        "delay": {"burden": dataclasses.replace(NOTHING, delay=2.0)},
        "motor_strength": {"burden": dataclasses.replace(NOTHING, strength=2.0)},
        "noise": {"noise": 2.0},
        "speed": {"speed": 2.0},
    }

    rigid = circumstances(PRESETS["rigid"], dict.fromkeys(KINDS, (2.0,)))
    assert {one.kind for one in rigid} == KINDS.keys() - {"motor_strength"}


def test_pushes_go_with_the_body_and_packs_count_as_weight():
    config = Config(body=BodyConfig(height=1.6, mass=60.0))
    values = {"stature": (0.4 * 1.6,), "mass": (90.0,), "backpack": (10.0,)}
    found = {(one.kind, one.own): one for one in circumstances(config, values)}
    ratios = {key: one.push_ratio(config) for key, one in found.items()}
    assert ratios["stature", False] == pytest.approx(0.4**3.5)  # m sqrt(h)
    assert ratios["mass", False] == pytest.approx(1.5)
    assert ratios["backpack", False] == ratios["mass", True] == 1.0
    assert found["backpack", False].kilograms == 70.0


def test_the_command_measures_each_circumstance_once(monkeypatch, tmp_path, capsys):
    asked = []

    def canned(subject, args, programs, burden):
        asked.append((subject.name, subject.config, burden, args.impulses))
        walking = {
            "survival": 0.5, "speed_mean": 0.9, "speed_std": 0.1,
            "step_length_mean": 0.4, "step_duration_mean": 0.4,
        }  # fmt: skip
        size = max(args.impulses)
        pushes = {"survival": [[1.0, float(burden.mass < 20)]], "impulses": list(args.impulses)}
        return {"walking": walking, "pushes": pushes, "threshold": {"forward": size, "backward": None}}

    monkeypatch.setattr(evaluation, "evaluate", canned)
    out = tmp_path / "g"
    options = "--walkers 8 --replicas 2 --impulses 40 --phases 2".split()
    assert cli.main(["generalise", "fixed", "--beside", "constant", "--out", str(out), *options]) == 0
    # Of each policy: its own once, and 4 statures, 1 mass, 2 + 2 packs, 2 forces, 2 frictions, 2 slopes,
    # 2 delays, 1 strength of motors, 3 noises and 4 speeds.
    assert len(asked) == len(set(map(str, asked))) == 2 * (1 + 4 + 1 + 2 + 2 + 2 + 2 + 2 + 2 + 1 + 3 + 4)
    result = json.loads((out / "generalise.json").read_text())
    rows = result["rows"]
    assert len(rows) == 2 * (25 + len(KINDS))
    found = {(row["policy"], row["kind"], row["value"]): row for row in rows}
    heavy = found["constant", "front_pack", 25.0]
    assert heavy["pushes_survived"]["survivors"] == 2
    assert heavy["threshold_per_kg"] == {"forward": pytest.approx(40 / 100), "backward": None}
    tall = found["fixed", "stature", 2.3]
    # Pushes go with m sqrt(h), m with h^3.
    assert tall["impulses"] == [pytest.approx(40 * (2.3 / 1.8) ** 3.5)]
    assert tall["threshold_per_kg"]["forward"] == pytest.approx(40 / 75 * (2.3 / 1.8) ** 0.5)
    assert found["fixed", "speed", 0.7]["speed_ratio"] == pytest.approx(0.9 / 0.7)
    assert found["fixed", "force", 0.0]["pushes_survived"]["survivors"] == 4
    with (out / "generalise.csv").open() as file:
        lines = list(csv.DictReader(file))
    assert len(lines) == len(rows)
    line = next(line for line in lines if (line["kind"], line["value"]) == ("front_pack", "25.0"))
    assert (line["policy"], line["mass_total"], line["pushes_survived"]) == ("fixed", "100.0", "0.5")
    assert "backpack 0*" in capsys.readouterr().out
    with Image.open(out / "generalise.png") as image:
        assert len(np.unique(np.asarray(image.convert("RGB")).reshape(-1, 3), axis=0)) > 50


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """(rows by kind and value, how often a program was made to move walkers)."""
    out, made = tmp_path_factory.mktemp("generalise"), []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(evaluation, "AFTER_PUSH", 1.0)  # what becomes of the pushed is not looked at
        real = trials.model_of
        patch.setattr(trials, "model_of", lambda *who: made.append(1) or real(*who))
        options = (
            "--walkers 4 --seconds 5 --impulses 10 --phases 1 --only backpack,friction,stature,speed,noise "
            "--backpacks 15 --frictions 0.02 --statures 2 --speeds 0.6 --noises 0 --beside none"
        )
        assert cli.main(["generalise", "replan", "--out", str(out), *options.split()]) == 0
    rows = json.loads((out / "generalise.json").read_text())["rows"]
    return {(row["kind"], row["value"]): row for row in rows}, len(made)


def test_the_walker_feels_what_surrounds_it(small):
    rows, _ = small
    own = rows["backpack", 0.0]
    assert own["never_fell"]["share"] == 1.0 and own["walking"]["speed_mean"] == pytest.approx(1.0, abs=0.1)
    assert rows["friction", 0.02]["never_fell"]["share"] == 0.0  # ice
    # A pack behind slows, a lower speed that is asked for too; a tall person steps further.
    assert rows["backpack", 15.0]["walking"]["speed_mean"] < own["walking"]["speed_mean"] - 0.05
    assert rows["speed", 0.6]["walking"]["speed_mean"] < own["walking"]["speed_mean"] - 0.1
    assert rows["stature", 2.0]["walking"]["step_length_mean"] > 1.05 * own["walking"]["step_length_mean"]


def test_one_program_serves_all_circumstances(small):
    assert small[1] <= 1  # none, where another test of this process has had the same one made


def test_rigid_legs_too_short_to_be_asked_before_their_toe_off_ends_are_refused(tmp_path, capsys):
    options = ["--statures", "1.1", "--beside", "none"]
    assert cli.main(["generalise", "shipped-rigid", "--out", str(tmp_path / "g"), *options]) == 2
    error = capsys.readouterr().err
    assert "--statures 1.1: --height 1.1: the toe-off of so short a walker" in error
    assert error.count("\n") == 1 and not (tmp_path / "g").exists()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--only", "weather"], "--only weather: give some of stature, mass, backpack"),
        (["--only", "mass,"], "--only : give some of"),
        (["--beside", "nobody-at-all"], "no policy 'nobody-at-all'"),
        (["--backpacks", "-1"], "--backpacks -1: give 0 to 100 kg"),
        (["--frictions", "0"], "--frictions 0: give 0.01 to 10"),
        (["--forces", "x"], "'x'"),
        (["--statures", "0.5"], "--statures 0.5: body mass"),
        (["--impulses", "0,10"], "--impulses 0: give -1000 to 1000 N s"),
        (["--replicas", "0"], "--replicas 0"),
    ],
)
def test_bad_options_are_one_line(options, said, tmp_path, capsys):
    assert cli.main(["generalise", "fixed", "--out", str(tmp_path / "g"), *options]) == 2
    error = capsys.readouterr().err
    assert said in error and error.count("\n") == 1
    assert not (tmp_path / "g").exists()
