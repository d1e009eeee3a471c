"""What the policy is told, and what its answer means on this walker's body."""

from __future__ import annotations

import numpy as np

from jaxwalk.deploy import sensors, step_clock
from jaxwalk.deploy.kinematics import Posture
from jaxwalk.deploy.person import Person
from jaxwalk.deploy.sensors import Estimate
from jaxwalk.deploy.step_clock import Clock


def observe(
    names: tuple[str, ...],
    who: Person,
    gravity: np.float32,
    posture: Posture,
    estimate: Estimate,
    clock: Clock,
    length: np.float32,
) -> np.ndarray:
    """[O] sensor values, scaled to the reference body (m, s, rad).

    Args:
      names: of the observables, in order.
      clock: of the step under way, or just begun.
      length: of the step that just ended, m.
    """
    stance = clock.stance
    known = {
        "speed": lambda: estimate.speed / who.speed,
        "pitch": lambda: estimate.pitch,
        "zmp": lambda: sensors.zmp_distance(who, gravity, posture, estimate, stance) / who.length,
        "step_length": lambda: length / who.length,
        "pitch_rate": lambda: estimate.pitch_rate / who.rate,
        "acceleration": lambda: estimate.acceleration,
        "speed_desired": lambda: who.gait.speed_desired / who.speed,
        "height": lambda: who.length,
        "com_ahead": lambda: sensors.com_ahead(who, posture, estimate, stance)[0] / who.length,
        "elapsed": lambda: clock.elapsed / who.speed,  # times go as speeds do
        "capture_ahead": lambda: (
            (sensors.capture_point(who, gravity, estimate) - posture.x[stance]) / who.length
        ),
        "swing_ahead": lambda: step_clock.step_length(posture, clock) / who.length,
        "delay": lambda: who.delay / who.speed,
    }
    return np.array([known[name]() for name in names], np.float32)


def to_command(who: Person, action: np.ndarray) -> tuple[np.float32, np.float32]:
    """From an action [2] in [-1, 1] to (length m, duration s) of the step, or of the change of its plan."""
    low, high = who.gait.answers
    share = np.float32(0.5) * (np.clip(action, -1, 1) + np.float32(1))
    length, duration = (a + x * (b - a) for a, b, x in zip(low, high, share, strict=True))
    return np.float32(length), np.float32(duration)
