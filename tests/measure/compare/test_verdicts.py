"""Who is compared, and what is made of figures that are known."""

from __future__ import annotations

import pytest

from jaxwalk.common.errors import UserError
from jaxwalk.measure.compare import groups, verdicts

REACH = {"forward": 80.0, "backward": 60.0}


def result(speed=1.0, survival=((1.0, 1.0), (1.0, 0.9)), recovery=((1.0, 2.0), (4.0, None))):
    """As `jaxwalk evaluate` gives it: two impulses, two phases."""
    return {
        "walking": {"speed_mean": speed, "survival": 0.75},
        "pushes": {"impulses": [-30.0, 50.0], "survival": survival, "recovery_seconds": recovery},
        "threshold": {"forward": 50.0, "backward": 30.0},
        "threshold_worst_phase": {"forward": 0.0, "backward": 30.0},
    }


def stands(name, forward, backward):
    """A policy whose seeds have these thresholds."""
    seeds = [
        {"worst_phase_forward": f, "worst_phase_backward": b} for f, b in zip(forward, backward, strict=True)
    ]
    return {"name": name, "spread": verdicts.spread(seeds)}


def test_entries_are_policies_or_named_seeds():
    found = groups.parse(["fixed", "ddpg=runs/a, runs/b", "one=shipped"])
    assert [(e.name, e.members) for e in found] == [
        ("fixed", ("fixed",)),
        ("ddpg", ("runs/a", "runs/b")),
        ("one", ("shipped",)),
    ]


def test_a_folder_with_an_equals_sign_in_its_name_is_a_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lr=3").mkdir()
    assert groups.parse(["lr=3"])[0].members == ("lr=3",)


@pytest.mark.parametrize(
    ("texts", "said"),
    [
        ([], "nothing to compare"),
        (["fixed", "fixed"], "'fixed' is given twice"),
        (["a=x", "a=y"], "'a' is given twice"),
        (["a=x,,y"], "'a=x,,y' is no group"),
        (["=x"], "'=x' is no group"),
        (["a=x,y,x"], "has 'x' twice"),
    ],
)
def test_bad_entries(texts, said):
    with pytest.raises(UserError, match=said):
        groups.parse(texts)


def test_figures_of_a_seed_in_their_order():
    found = verdicts.figures(result(), [-30.0], {"footsteps": 80_000, "seconds": None})
    assert found == {
        "speed": 1.0,
        "survival_unpushed": 0.75,
        "worst_phase_forward": 0.0,
        "worst_phase_backward": 30.0,
        "all_phases_forward": 50.0,
        "all_phases_backward": 30.0,
        "recovery_seconds": 1.5,  # of the shared impulse alone
        "survival_-30": 1.0,
        "survival_+50": 0.95,
        "survival_worst_phase_-30": 1.0,
        "survival_worst_phase_+50": 0.9,
        "training_footsteps": 80_000,
        "training_seconds": None,
    }


def test_recovery_is_compared_where_everybody_survives():
    weak = result(survival=((1.0, 1.0), (0.5, 0.5)))
    assert verdicts.common([-30.0, 50.0], [result()]) == [-30.0, 50.0]
    assert verdicts.common([-30.0, 50.0], [result(), weak]) == [-30.0]
    assert verdicts.figures(result(), [], {})["recovery_seconds"] is None


def test_spread_over_seeds_by_hand():
    seeds = [{"speed": 1.0, "x": None}, {"speed": 1.2, "x": 3.0}, {"speed": 1.4, "x": None}]
    found = verdicts.spread(seeds)
    assert found["speed"] == pytest.approx({"mean": 1.2, "sd": 0.2, "min": 1.0, "max": 1.4})
    assert found["x"] == {"mean": 3.0, "sd": None, "min": 3.0, "max": 3.0}
    assert verdicts.spread([{"y": None}])["y"] == {"mean": None, "sd": None, "min": None, "max": None}


@pytest.mark.parametrize("swapped", [False, True])
def test_beating_takes_both_directions(swapped):
    strong, weak = stands("strong", [60, 80], [40, 50]), stands("weak", [50], [30])
    found = verdicts.verdict(*((weak, strong) if swapped else (strong, weak)), REACH)
    assert found is not None and found == verdicts.Verdict(
        "strong",
        "weak",
        "beats",
        {"forward": (70.0, 50.0), "backward": (45.0, 30.0)},
        {"forward": (True, False), "backward": (False, False)},
        every_seed=True,
    )
    assert verdicts.sentence(found) == (
        "strong beats weak at the worst phase in both directions (every seed): "
        "forward 70+ against 50 N s (+20), backward 45 against 30 N s (+15)"
    )


def test_seeds_that_overlap_are_told():
    found = verdicts.verdict(stands("a", [60, 80], [40, 50]), stands("b", [60], [30]), REACH)
    assert found is not None and found.kind == "beats" and not found.every_seed


@pytest.mark.parametrize(
    ("forward", "backward", "kind"),
    [(60, 30, "mixed"), (40, 40, "mixed"), (50, 30, "alike"), (50, 40, "mixed")],
)
def test_anything_else_is_no_victory(forward, backward, kind):
    found = verdicts.verdict(stands("a", [forward], [backward]), stands("b", [50], [30]), REACH)
    assert found is not None
    assert (found.better, found.kind, found.every_seed) == ("a", kind, False)


def test_directions_that_nobody_tried_do_not_count_and_the_grid_s_end_is_marked():
    found = verdicts.verdict(stands("a", [80], [None]), stands("b", [50], [None]), REACH)
    assert found is not None
    assert verdicts.sentence(found) == (
        "a beats b at the worst phase in the direction tried (every seed): forward 80+ against 50 N s (+30)"
    )
    assert verdicts.verdict(stands("a", [None], [None]), stands("b", [None], [None]), REACH) is None


def test_nothing_is_decided_where_the_grid_ends_before_both():
    found = verdicts.verdict(stands("a", [80, 80], [40, 40]), stands("b", [80], [30]), REACH)
    assert found is not None and found.kind == "undecided"
    assert "forward 80+ against 80+ N s" in verdicts.sentence(found)
