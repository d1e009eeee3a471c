"""Cycles out of sole forces: hand-made contact patterns."""

import numpy as np
import pytest

from jaxwalk.measure.gait import strides


def pattern(text):
    """[T] contact from a drawing: '#' on the floor, '.' in the air."""
    return np.array([c == "#" for c in text])


def walking(cycle=100, stance=60, count=4):
    """[T, 2]: left lands at 20, 20 + cycle, ...; right half a cycle later; each stands for ``stance``."""
    ticks = np.arange(20 + cycle * count)
    sides = [((ticks - 20 - shift) % cycle) < stance for shift in (0, cycle // 2)]
    return np.stack(sides, axis=1)


@pytest.mark.parametrize(
    ("seen", "meant"),
    [
        ("....#.#######....", "....#########...."),  # it bounces at touch-down
        ("....########.#...", "....##########..."),  # and at toe-off
        (".....#.....######", "...........######"),  # it scuffs in swing
        ("#....######.....#", "#....######.....#"),  # nobody knows how long what is cut off lasts
        ("...##..##..##....", "...##########...."),
    ],
)
def test_bounces_and_scuffs_are_no_steps(seen, meant):
    np.testing.assert_array_equal(strides.settled(pattern(seen), 3), pattern(meant))


def test_every_whole_cycle_is_found_with_its_shares():
    found, odd = strides.cycles(walking())
    left = [c for c in found if c.side == 0]
    right = [c for c in found if c.side == 1]
    assert odd == 0
    assert [(c.start, c.stop) for c in left] == [(20, 120), (120, 220), (220, 320)]
    assert [(c.start, c.stop) for c in right] == [(70, 170), (170, 270), (270, 370)]
    for c in found:
        assert c.ticks == 100 and c.other == c.start + 50
        assert c.stance_share == pytest.approx(0.6)
        # Each leg stands 60 of 100: they overlap for 10, twice.
        assert c.double_support == pytest.approx(0.2)


def test_a_cycle_without_the_other_leg_s_step_is_left_out():
    contact = walking()
    contact[60:160, 1] = False  # the right leg hops over its landing at 70
    found, odd = strides.cycles(contact)
    assert [(c.side, c.start, c.stop) for c in found] == [
        (0, 120, 220), (0, 220, 320), (1, 170, 270), (1, 270, 370),
    ]  # fmt: skip
    assert odd == 1


def test_standing_still_has_no_cycle():
    assert strides.cycles(np.ones((50, 2), bool)) == ([], 0)


def test_a_cycle_is_stretched_to_a_hundred_per_cent():
    cycle = strides.Cycle(side=0, start=10, stop=60, toe_off=40, other=35, double_support=0.2)
    ramp = np.arange(70.0)
    curve = strides.normalised(ramp, cycle)
    np.testing.assert_allclose(curve, 10 + 0.5 * np.arange(101))
    several = strides.normalised(np.stack([ramp, -ramp], axis=1), cycle)
    np.testing.assert_allclose(several, np.stack([curve, -curve], axis=1))
