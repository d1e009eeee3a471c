"""The step that the controllers plan by themselves: see `jaxwalk.control.compliant.step_plan`."""

from __future__ import annotations

import numpy as np

from jaxwalk.deploy.compliant.stance import faster
from jaxwalk.deploy.kinematics import Posture
from jaxwalk.deploy.person import Person
from jaxwalk.deploy.sensors import Estimate, capture_point
from jaxwalk.deploy.step_clock import Clock


def planned(
    who: Person, gravity: np.float32, posture: Posture, clock: Clock, estimate: Estimate, error: np.float32
) -> tuple[np.float32, np.float32]:
    """The step from now on, with what the policy changes of it: (length m, duration s)."""
    numbers, own, legs, more = who.gait, who.gait.step_plan, who.gait.compliant, faster(who)
    usual = numbers.length_nominal + legs.length_speed * more
    length = usual + own.length_gain * error + own.pitch_gain * max(estimate.pitch, own.pitch_least)
    time = numbers.duration_nominal + legs.duration_speed * more - own.duration_gain * error
    most = min(own.duration_most, numbers.duration_max)
    length, time = max(length, own.length_least), min(max(time, own.duration_least), most)
    capture, stance = capture_point(who, gravity, estimate), posture.x[clock.stance]
    if capture - stance < -own.back_margin:
        place = min(own.back_gain * capture - own.back_reach, stance - own.back_least)
        way = posture.x[clock.swing] - place
        way = max(way, -own.back_beyond * way)
        length = np.float32(2) * place
        time = clock.elapsed + min(max(way / own.back_speed, own.back_soonest), own.back_time)
    more, longer = clock.change
    length = min(max(length + more, numbers.length_min), numbers.length_max)
    longest = max(numbers.duration_max, min(time, own.back_latest))
    time = min(max(time + longer, numbers.duration_min), longest)
    return np.float32(length), np.float32(time)
