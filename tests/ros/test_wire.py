"""Messages as a frame tells them."""

from __future__ import annotations

import math

import pytest

from jaxwalk.ros import wire


def test_joints_states_are_of_the_walkers_joints_in_their_order():
    names, angles, rates = ("a", "b"), [1.0, 2.0], [3.0, 4.0]
    assert wire.states(names, ["a", "b"], angles, rates) == {"joints": (1.0, 2.0), "joint_rates": (3.0, 4.0)}
    for wrong in ((["b", "a"], angles, rates), ([], [], []), (["a", "b"], angles, []), (["a"], [1.0], [3.0])):
        with pytest.raises(ValueError, match=wire.JOINTS):
            wire.states(names, *wrong)


@pytest.mark.parametrize("angle", [-3.1, -1.0, 0.0, 0.2, 3.0, math.pi])
def test_a_quaternion_and_its_negative_are_one_pitch(angle):
    y, w = wire.turned(angle)
    assert wire.pitch(y, w) == pytest.approx(angle, abs=1e-15) and wire.pitch(-y, -w) == wire.pitch(y, w)


def test_half_a_turn_is_positive():
    assert wire.pitch(-1.0, 0.0) == wire.pitch(1.0, 0.0) == wire.pitch(1.0, -0.0) == math.pi
