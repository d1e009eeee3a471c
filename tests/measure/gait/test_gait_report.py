"""``jaxwalk gait`` from the outside."""

import csv
import json

import numpy as np
import pytest

from jaxwalk import cli
from jaxwalk.measure.evaluate import evaluation
from jaxwalk.measure.gait import measures, report, signals

OPTIONS = "--walkers 4 --seconds 12 --speeds 0.9,2.9".split()


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    folder = tmp_path_factory.mktemp("gait") / "deep" / "folder"
    assert cli.main(["gait", "replan", "--out", str(folder), *OPTIONS]) == 0
    return folder


@pytest.fixture(scope="module")
def result(out):
    return json.loads((out / "gait.json").read_text())


@pytest.fixture(scope="module")
def curves(out):
    """(quantity, side) -> [101] mean."""
    found = {}
    with (out / "gait.csv").open() as file:
        for row in csv.DictReader(file):
            found.setdefault((row["quantity"], row["side"]), []).append(float(row["mean"]))
    return {name: np.array(values) for name, values in found.items()}


def test_all_files_are_written(out, result, curves):
    assert sorted(path.name for path in out.iterdir()) == ["gait.csv", "gait.json", "gait.png"]
    assert (out / "gait.png").read_bytes().startswith(b"\x89PNG")
    assert set(result["measures"]) == set(measures.UNITS)
    assert {name for name, _ in curves} == set(signals.UNITS)
    assert {values.shape for values in curves.values()} == {(101,)}
    assert result["config"]["body"]["mass"] == 75.0 and result["options"]["walkers"] == 4
    assert {"hardware", "versions", "policy_digest", "sources", "definitions"} <= set(result)


def test_the_ground_carries_the_body_and_neither_brakes_nor_drives_it(curves):
    over_cycle = {name: np.trapezoid(curves[name], dx=0.01) for name in curves}
    vertical, fore_aft = (
        sum(over_cycle[name, side] for side in report.SIDES) for name in ("vertical_force", "fore_aft_force")
    )
    assert vertical == pytest.approx(1.0, abs=0.01)
    assert fore_aft == pytest.approx(0.0, abs=0.005)


def test_what_actuators_give_is_what_damping_and_landing_take(result):
    told = {name: one["mean"] for name, one in result["measures"].items()}
    lost = told["damping_loss"] + told["contact_loss"]
    assert told["cost_of_transport_net"] == pytest.approx(lost, rel=0.05)
    assert told["cost_of_transport"] > told["cost_of_transport_by_leg"] > told["cost_of_transport_net"] > 0
    given, taken = (
        sum(told[f"{joint}_work_{kind}"] for joint in signals.JOINTS) for kind in ("positive", "negative")
    )
    assert given == pytest.approx(told["cost_of_transport"])
    assert given - taken == pytest.approx(told["cost_of_transport_net"])
    assert told["cost_of_transport_filtered"] == pytest.approx(told["cost_of_transport"], rel=0.25)


def test_an_impact_is_smaller_the_more_it_is_filtered(result):
    told = {name: one["mean"] for name, one in result["measures"].items()}
    assert told["impact_peak"] > told["impact_peak_50_hz"] > told["vertical_loading_peak"]


def test_speed_length_and_cadence_agree_with_each_other_and_with_evaluate(result, tmp_path):
    told = {name: one["mean"] for name, one in result["measures"].items()}
    assert told["stride_length"] * told["cadence"] / 120 == pytest.approx(told["speed"], rel=0.01)
    assert 2 * told["step_length"] == pytest.approx(told["stride_length"], rel=0.03)
    assert told["stance_share"] == pytest.approx(50 + told["double_support_share"] / 2, abs=2)
    assert result["fell"] == 0 and min(result["strides"].values()) > 4 * 4
    # The same walkers by the controller's own count of steps.
    options = "--walkers 4 --seconds 12 --impulses 10 --phases 1 --replicas 1".split()
    file = tmp_path / "replan.json"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(evaluation, "AFTER_PUSH", 0.0)
        assert cli.main(["evaluate", "replan", *options, "--json", str(file)]) == 0
    walking = json.loads(file.read_text())["walking"]
    assert told["speed"] == pytest.approx(walking["speed_mean"], rel=0.02)
    assert told["step_time"] == pytest.approx(walking["step_duration_mean"], rel=0.03)
    by_count = walking["speed_mean"] * walking["step_duration_mean"]
    assert told["step_length"] == pytest.approx(by_count, rel=0.03)
    # It measures at the landing, from an ankle that its rising heel has brought forward by then.
    assert 0.0 < told["step_length"] - walking["step_length_mean"] < 0.05


def test_the_same_report_may_be_written_anew_but_no_other_one(out, result, capsys, monkeypatch):
    def no_walk(*args, **settings):
        raise AssertionError("nobody should walk before the folder is found good")

    before = {path: path.read_bytes() for path in out.iterdir()}
    with monkeypatch.context() as patch:
        patch.setattr(report.record, "record", no_walk)
        for other in (["--seed", "1"], ["--mass", "80"]):
            assert cli.main(["gait", "replan", "--out", str(out), *OPTIONS, *other]) == 2
            error = capsys.readouterr().err
            assert error.count("\n") == 1 and "gait.json holds the report of another" in error
        with pytest.raises(AssertionError, match="nobody"):
            cli.main(["gait", "replan", "--out", str(out), *OPTIONS])
    assert {path: path.read_bytes() for path in out.iterdir()} == before


@pytest.mark.parametrize(("name", "says"), [("gait.json", "gait.json: not JSON"), ("gait.png", "of no gait")])
def test_files_of_others_are_left_alone(tmp_path, capsys, name, says):
    (tmp_path / name).write_text("precious")
    assert cli.main(["gait", "replan", "--out", str(tmp_path), *OPTIONS]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and says in error and "--out" in error
    assert (tmp_path / name).read_text() == "precious" and len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--walkers", "0"], "--walkers 0"),
        (["--seconds", "3"], "--seconds 3: give 6"),
        (["--speed", "0"], "--speed 0"),
        (["--mass", "-3"], "between 5 and 500 kg"),
        (["--noise", "-1"], "--noise -1"),
        (["--seed", "-1"], "--seed -1"),
    ],
)
def test_bad_options_are_one_line(tmp_path, capsys, options, says):
    folder = tmp_path / "new"
    assert cli.main(["gait", "replan", "--out", str(folder), *options]) == 2
    error = capsys.readouterr().err
    assert error.startswith("jaxwalk: error: ") and error.count("\n") == 1 and says in error
    assert not folder.exists()


def test_who_only_falls_has_no_gait(tmp_path, capsys):
    """Nobody walks with sensors that are a hundred times worse than real ones."""
    code = cli.main(["gait", "replan", "--out", str(tmp_path), *OPTIONS, "--noise", "100"])
    error = capsys.readouterr().err
    assert code == 2 and error.count("\n") == 1
    assert "no whole stride" in error and "4 of 4 walkers fell" in error
    assert list(tmp_path.iterdir()) == []


def test_other_speeds_are_told_beside_people_at_the_same(result):
    """Van der Zee's people at 0.9 m/s: 0.61 m; who is asked for what nobody can walk is told as fallen."""
    slow, far = result["speeds"]
    told = {name: one["mean"] for name, one in slow["measures"].items()}
    assert (slow["asked"], slow["fell"]) == (0.9, 0)
    assert told["speed"] == pytest.approx(0.9, abs=0.12)
    assert told["step_length"] * told["cadence"] / 60 == pytest.approx(told["speed"], rel=0.03)
    people = slow["measures"]["step_length"]["human"]
    assert people["source"] == "van der Zee 2022" and people["mean"] == pytest.approx(0.61, abs=0.05)
    assert far["asked"] == 2.9 and (far["measures"] is None) == (far["fell"] == 4)
