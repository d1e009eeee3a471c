"""Intervals and thresholds against known numbers."""

import numpy as np
import pytest

from jaxwalk import statistics


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
    found = statistics.wilson(np.array([survivors]), trials)
    np.testing.assert_allclose(np.concatenate(found), [low, high], atol=1e-4)


def test_threshold_is_the_prefix_of_the_grid():
    impulses = [-30.0, -20.0, -10.0, 10.0, 20.0, 30.0, 40.0]
    # An island of survival above a failure does not count.
    survival = [1.0, 0.9, 1.0, 1.0, 0.95, 0.94, 1.0]
    assert statistics.threshold(impulses, survival) == {"forward": 20.0, "backward": 10.0}


def test_threshold_of_a_walker_that_survives_nothing_is_zero():
    assert statistics.threshold([-10.0, 10.0], [0.0, 0.0]) == {"forward": 0.0, "backward": 0.0}


def test_a_direction_that_nobody_tried_has_no_threshold():
    assert statistics.threshold([10.0, 20.0], [1.0, 0.5]) == {"forward": 10.0, "backward": None}
