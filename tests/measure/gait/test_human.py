"""Published figures stand where they belong."""

import numpy as np
import pytest

from jaxwalk.measure.gait import human, measures, picture, signals

FASTER_THAN_MEASURED = 9.0  # m/s, so that all is of people at their own pace


def test_every_figure_is_of_a_measure_and_has_a_source():
    for name, told in human.HUMAN.items():
        assert name in measures.UNITS
        assert told.source in human.SOURCES
        if told.low is not None:
            assert told.high is not None and told.low <= told.mean <= told.high
        if told.curve is not None:
            assert told.curve in signals.UNITS and told.percent is not None and 0 <= told.percent <= 100
    assert {told.source for told in human.people(1.8, 1.0).values()} == set(human.SOURCES)


def test_people_s_figures_agree_with_each_other():
    """Speed = stride length x cadence / 2, and stances that overlap leave double support."""
    for height in (human.STATURE, 1.8):
        told = {name: one.mean for name, one in human.people(height, FASTER_THAN_MEASURED).items()}
        assert abs(told["stride_length"] * told["cadence"] / 120 / told["speed"] - 1) < 0.02
        # Shares are published as whole per cent.
        assert abs(2 * told["stance_share"] - 100 - told["double_support_share"]) <= 1.5
        given = sum(told[f"{joint}_work_positive"] for joint in signals.JOINTS)
        assert abs(given - told["cost_of_transport"]) < 0.002


def test_people_are_brought_to_the_walkers_stature():
    """Twice as tall: twice the stride, 1.41 times the speed; angles and body weights stay."""
    one, two = (human.people(share * human.STATURE, FASTER_THAN_MEASURED) for share in (1, 2))
    assert one == human.HUMAN
    share = {name: two[name].mean / one[name].mean for name in one}
    root = np.sqrt(2)
    told = {
        "speed": root, "cadence": 1 / root, "stride_length": 2.0, "stance_share": 1.0,
        "knee_flexion_swing": 1.0, "vertical_loading_peak": 1.0, "ankle_plantarflexor_moment": 2.0,
        "ankle_power_generated": root, "cost_of_transport": 1.0,
    }  # fmt: skip
    assert {name: share[name] for name in told} == pytest.approx(told)
    assert two["speed"].high == pytest.approx(root * one["speed"].high)
    # What adults of 1.8 m do is known well enough to see a slip: 1.2 to 1.5 m/s, 100 to 120 steps a minute.
    adult = human.people(1.8, FASTER_THAN_MEASURED)
    assert 1.2 < adult["speed"].mean < 1.5 and 100 < adult["cadence"].mean < 120


def test_people_walk_at_the_walkers_own_speed():
    """Van der Zee's table at the adults' stature, midway between two of its speeds, and as similar bodies."""
    told = human.people(human.ADULTS, 0.9)
    assert told["step_length"].mean == pytest.approx(0.607)
    assert told["step_length"].low == pytest.approx(0.607 - 0.053)
    assert told["cost_of_transport_by_leg"].mean == pytest.approx(0.0679)
    between = human.people(human.ADULTS, 1.0)
    assert between["step_length"].mean == pytest.approx((0.607 + 0.652) / 2)
    taller = human.people(4 * human.ADULTS, 2.0)  # moves as the adults do at 1 m/s
    assert taller["stride_length"].mean == pytest.approx(8 * between["step_length"].mean)
    assert taller["cost_of_transport_by_leg"] == between["cost_of_transport_by_leg"]
    for one, speed in ((told, 0.9), (between, 1.0), (taller, 2.0)):
        assert one["step_length"].mean * one["cadence"].mean / 60 == pytest.approx(speed)
        low, high = one["cadence"].low, one["cadence"].high
        assert low is not None and high is not None and low < one["cadence"].mean < high
    # Beyond what was measured nothing is made up.
    assert human.people(human.ADULTS, 0.69)["step_length"].source == "Schwartz 2008"


def test_every_curve_has_its_panel():
    assert sorted(picture.ORDER) == sorted(signals.UNITS)
