"""Intervals and thresholds against known numbers."""

import numpy as np
import pytest

from jaxwalk.measure import survival


@pytest.mark.parametrize(
    ("survivors", "trials", "low", "high"),
    [
        # Wilson's formula by hand, z = 1.95996: for 8 of 8, low = 1 / (1 + z^2 / 8) = 0.67561.
        (8, 8, 0.67561, 1.0),
        (0, 8, 0.0, 0.32439),
        (81, 263, 0.25529, 0.36621),  # Newcombe, Statistics in Medicine 17, 1998, table I
        (15, 148, 0.06242, 0.16054),
        (0, 20, 0.0, 0.16113),
        (1, 29, 0.00611, 0.17176),
    ],
)
def test_wilsons_interval(survivors, trials, low, high):
    found = survival.wilson(np.array([survivors]), trials)
    np.testing.assert_allclose(np.concatenate(found), [low, high], atol=1e-4)


def test_wilsons_interval_holds_the_share_itself():
    for trials in range(1, 300):
        survivors = np.arange(trials + 1)
        low, high = survival.wilson(survivors, trials)
        assert (low <= survivors / trials).all() and (survivors / trials <= high).all()


@pytest.mark.parametrize(
    ("table", "forward", "backward"),
    [
        ({10: 1.0, 20: 0.96, 30: 0.95, 40: 0.94}, 30, None),
        ({10: 1.0, 20: 0.90, 30: 1.0}, 10, None),  # an island beyond a failure does not count
        ({10: 0.5, 20: 1.0}, 0, None),
        ({30: 1.0, 10: 1.0, 20: 1.0}, 30, None),  # in any order
        ({-10: 1.0, -20: 0.99, -30: 0.2, -40: 1.0, 10: 0.0}, 0, 20),
        ({-40: 1.0, 30: 1.0}, 30, 40),
        ({0: 0.0, 10: 1.0}, 10, None),  # no push is neither forward nor backward
        ({}, None, None),
    ],
)
def test_a_threshold_is_survived_with_all_below_it(table, forward, backward):
    found = survival.threshold([float(i) for i in table], list(table.values()))
    assert found == {"forward": forward, "backward": backward}


def test_the_worst_phase_is_each_way_the_weakest():
    each = survival.each_phase([-20.0, 10.0, 20.0], [[1.0, 1.0], [1.0, 1.0], [1.0, 0.5]])
    assert each == [{"forward": 20, "backward": 20}, {"forward": 10, "backward": 20}]
    assert survival.worst_phase(each) == {"forward": 10, "backward": 20}
    one_way = survival.each_phase([10.0], [[1.0, 0.0]])
    assert survival.worst_phase(one_way) == {"forward": 0, "backward": None}
