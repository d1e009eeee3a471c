"""Published figures stand where they belong."""

from jaxwalk.gaitlab import human, measures, picture, signals


def test_every_figure_is_of_a_measure_and_has_a_source():
    for name, told in human.HUMAN.items():
        assert name in measures.UNITS
        assert told.source in human.SOURCES
        if told.low is not None:
            assert told.low <= told.mean <= told.high
        if told.curve is not None:
            assert told.curve in signals.UNITS and 0 <= told.percent <= 100
    assert {told.source for told in human.HUMAN.values()} == set(human.SOURCES)


def test_people_s_figures_agree_with_each_other():
    """Speed = stride length x cadence / 2, and stances that overlap leave double support."""
    told = {name: one.mean for name, one in human.HUMAN.items()}
    assert abs(told["stride_length"] * told["cadence"] / 120 / told["speed"] - 1) < 0.05
    assert abs(2 * told["stance_share"] - 1 - told["double_support_share"]) < 1e-9


def test_every_curve_has_its_panel():
    assert sorted(picture.ORDER) == sorted(signals.UNITS)
