"""Published figures stand where they belong."""

import numpy as np
import pytest

from jaxwalk.measure.gait import human, measures, picture, signals


def test_every_figure_is_of_a_measure_and_has_a_source():
    for name, told in human.HUMAN.items():
        assert name in measures.UNITS
        assert told.source in human.SOURCES
        if told.low is not None:
            assert told.high is not None and told.low <= told.mean <= told.high
        if told.curve is not None:
            assert told.curve in signals.UNITS and told.percent is not None and 0 <= told.percent <= 100
    assert {told.source for told in human.HUMAN.values()} == set(human.SOURCES)


def test_people_s_figures_agree_with_each_other():
    """Speed = stride length x cadence / 2, and stances that overlap leave double support."""
    for height in (human.STATURE, 1.8):
        told = {name: one.mean for name, one in human.people(height).items()}
        assert abs(told["stride_length"] * told["cadence"] / 120 / told["speed"] - 1) < 0.02
        # Shares are published as whole per cent.
        assert abs(2 * told["stance_share"] - 100 - told["double_support_share"]) <= 1.5
        given = sum(told[f"{joint}_work_positive"] for joint in signals.JOINTS)
        assert abs(given - told["cost_of_transport"]) < 0.002


def test_people_are_brought_to_the_walkers_stature():
    """Twice as tall: twice the stride, 1.41 times the speed; angles and body weights stay."""
    one, two = human.people(human.STATURE), human.people(2 * human.STATURE)
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
    adult = human.people(1.8)
    assert 1.2 < adult["speed"].mean < 1.5 and 100 < adult["cadence"].mean < 120


def test_every_curve_has_its_panel():
    assert sorted(picture.ORDER) == sorted(signals.UNITS)
