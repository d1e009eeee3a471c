"""Instruments that are told late."""

import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.config import DELAY_MOST
from jaxwalk.control import latency
from jaxwalk.control.sensors import Estimate

DT = 0.002


def told(number):
    """All instruments say ``number``."""
    x = jnp.float32(number)
    return Estimate(
        speed=x, acceleration=x, pitch=x, pitch_rate=x, joints=jnp.full((2, 3), x),
        joint_rates=jnp.full((2, 3), x), touch=jnp.full(2, x),
    )  # fmt: skip


@pytest.mark.parametrize("delay", [0.0, 0.002, 0.02, DELAY_MOST])
def test_torso_and_soles_are_known_so_many_ticks_later_and_joints_at_once(delay):
    late, known = latency.start(DT, told(-1)), []
    for number in range(30):
        late, estimate = latency.tick(DT, jnp.float32(delay), late, told(number))
        known.append(estimate)
        np.testing.assert_array_equal(estimate.joints, number)
        np.testing.assert_array_equal(estimate.joint_rates, number)
    ticks = round(delay / DT)
    # Before the first one has come, what was told at the start.
    expected = [-1.0] * ticks + list(range(30 - ticks))
    for name in ("speed", "acceleration", "pitch", "pitch_rate"):
        np.testing.assert_array_equal([getattr(one, name) for one in known], expected)
    np.testing.assert_array_equal(np.array([one.touch for one in known]).T, [expected, expected])
