"""The limits against hand-worked numbers and against a pendulum that is pushed and steps as best it can."""

import math

import numpy as np
import pytest

from jaxwalk.measure.push_map import capturability
from jaxwalk.measure.push_map.capturability import Pendulum

PENDULUM = Pendulum(height=1.0, mass=75.0, step=0.6, seconds=0.6, longest=0.8, shortest=0.3)
TIMES = np.array([0.0, 0.15, 0.3, 0.45, 0.6])


@pytest.mark.parametrize(
    ("curve", "newton_seconds"),
    [
        (capturability.forward_fixed, [15, 23, 37, 59, 95]),
        (capturability.forward_replanned, [95, 152, 161, 122, 59]),
        (capturability.backward, [25, 41, 65, 104, 166]),
    ],
)
def test_known_numbers(curve, newton_seconds):
    np.testing.assert_allclose(curve(PENDULUM, TIMES), newton_seconds, atol=0.6)


def test_capture_distance_rises_to_its_limit():
    footed = Pendulum(1.0, 75.0, 0.6, 0.6, 0.8, 0.3, half_foot=0.1)
    assert capturability.capture_distance(footed, 0) == 0.1
    # 0.1 + 0.8 exp(-3.1321 x 0.3) = 0.1 + 0.8 x 0.39076
    assert capturability.capture_distance(footed, 1) == pytest.approx(0.41261, abs=1e-4)
    for pendulum in (PENDULUM, footed):
        far = capturability.capture_distance(pendulum, 60)
        assert capturability.capture_distance(pendulum) == pytest.approx(far)


def survives(pendulum: Pendulum, speed_change: float, time: float, replan: bool) -> bool:
    """A pendulum in steady walking is pushed at ``time``, then takes its longest, soonest steps.

    Position and speed are integrated in closed form between events; nothing here knows of capture points.
    """
    omega, period = pendulum.omega, pendulum.seconds

    def swing(x: float, v: float, t: float) -> tuple[float, float]:
        grow, shrink = math.cosh(omega * t), math.sinh(omega * t)
        return x * grow + v / omega * shrink, x * omega * shrink + v * grow

    # Periodic walking: x from -s/2 to s/2 about the foot, with the speed that takes it there in T.
    half = pendulum.step / 2
    x, v = swing(-half, omega * half / math.tanh(omega * period / 2), time)
    v += speed_change
    left, length = period - time, pendulum.step
    if replan:
        left, length = max(pendulum.shortest - time, capturability.REDIRECT_SECONDS), pendulum.longest
    for _ in range(60):
        if x < 0 and v < 0:
            return False  # over the foot backward; it cannot step back
        x, v = swing(x, v, left)
        if abs(v) > 1e3 or (x < 0 and v < 0):
            return False
        if v < omega * pendulum.longest * 1e-9 or (x - length <= 0 and v <= -omega * (x - length)):
            return True  # the new foot is far enough ahead to stop it
        x, left, length = x - length, pendulum.shortest, pendulum.longest
    return False


@pytest.mark.parametrize("time", TIMES.tolist())
@pytest.mark.parametrize("replan", [False, True])
def test_forward_limits_are_those_of_a_rollout(time, replan):
    curve = capturability.forward_replanned if replan else capturability.forward_fixed
    limit = float(curve(PENDULUM, time)) / PENDULUM.mass
    assert survives(PENDULUM, 0.995 * limit, time, replan)
    assert not survives(PENDULUM, 1.005 * limit, time, replan)


@pytest.mark.parametrize("time", TIMES.tolist())
def test_the_backward_limit_is_that_of_a_rollout(time):
    limit = float(capturability.backward(PENDULUM, time)) / PENDULUM.mass
    omega = PENDULUM.omega
    half = PENDULUM.step / 2
    start = omega * half / math.tanh(omega * PENDULUM.seconds / 2)
    x = -half * math.cosh(omega * time) + start / omega * math.sinh(omega * time)
    v = -half * omega * math.sinh(omega * time) + start * math.cosh(omega * time)
    for share, passes in ((0.995, True), (1.005, False)):
        # Long after, a pendulum that passes over its foot is ahead of it, one that does not is behind.
        later = x * math.cosh(20) + (v - share * limit) / omega * math.sinh(20)
        assert (later > 0) == passes
