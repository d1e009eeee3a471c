"""The leg that stands: it holds the torso, yields under the load, and pushes off before the other lands."""

from __future__ import annotations

import numpy as np

from jaxwalk.deploy.kinematics import Posture
from jaxwalk.deploy.person import Person
from jaxwalk.deploy.sensors import Estimate, capture_point
from jaxwalk.deploy.step_clock import Clock

_ERROR_MOST = np.float32(2)
_ZERO, _ONE = np.float32(0), np.float32(1)
_BALANCE_RAMP = np.float32(0.1)


def faster(who: Person) -> np.float32:
    """How much faster is asked for than the numbers are of, m/s."""
    return np.float32(who.gait.speed_desired - who.gait.compliant.speed_usual)


def lagging(who: Person, clock: Clock, estimate: Estimate, timestep: np.float32) -> np.float32:
    """How far the walker has fallen behind the speed asked for of late, m, a tick on."""
    own = who.gait.compliant
    off = min(max(who.gait.speed_desired - estimate.speed, -own.lag_speed), own.lag_speed)
    lag = clock.lag + timestep * (off - clock.lag / own.lag_seconds)
    return np.float32(min(max(lag, -own.lag_most), own.lag_most))


def capture_error(
    who: Person, gravity: np.float32, posture: Posture, clock: Clock, estimate: Estimate
) -> np.float32:
    """How much further ahead the capture point will be at the landing than in steady walking, m."""
    own = who.gait.compliant
    more = faster(who)
    left = max(own.landing_time + own.duration_speed * more - clock.elapsed, _ZERO)
    ahead = capture_point(who, gravity, estimate) - posture.x[clock.stance]
    usual = own.landing_capture + own.capture_speed * more + own.lag_capture * clock.lag
    error = ahead * np.exp(np.sqrt(gravity / who.leg) * left) - usual
    most = _ERROR_MOST * who.leg
    return min(max(error, -most), most)


def hip(who: Person, posture: Posture, clock: Clock, estimate: Estimate, error: np.float32) -> np.float32:
    """Torque of the stance hip, N m."""
    own, stance = who.gait.compliant, clock.stance
    speed = max(estimate.speed - who.torso * estimate.pitch_rate, own.hip_speed_min)
    ankle_rate = speed / -posture.z[stance]
    off = estimate.pitch - own.lag_pitch * clock.lag - own.pitch_offset - own.pitch_capture_gain * error
    rate = min(max(-ankle_rate * off / own.pitch_nominal, -own.hip_rate_max), own.hip_rate_max)
    return own.hip_damping * (rate - estimate.joint_rates[stance, 0])


def knee(who: Person, clock: Clock, estimate: Estimate) -> np.float32:
    """Torque of the stance knee, N m."""
    own = who.gait.compliant
    share = min(max(clock.elapsed / own.knee_seconds, _ZERO), _ONE)
    rest = own.knee_loading + (own.knee_standing - own.knee_loading) * share
    angle, rate = estimate.joints[clock.stance, 1], estimate.joint_rates[clock.stance, 1]
    return own.knee_stiffness * (rest - angle) - own.knee_damping * rate


def push_off(who: Person, estimate: Estimate, lag: np.float32) -> np.float32:
    """Plantarflexion torque of a whole push-off, N m, never negative."""
    own = who.gait.compliant
    lost = own.push_off_share * who.gait.speed_desired - estimate.speed
    usual = own.push_off_torque + own.push_off_speed * faster(who)
    return max(usual + own.push_off_gain * lost + own.lag_push_off * lag, _ZERO)


def ankle(
    who: Person,
    gravity: np.float32,
    posture: Posture,
    clock: Clock,
    estimate: Estimate,
    error: np.float32,
) -> np.float32:
    """Torque of the stance ankle, N m."""
    own, stance = who.gait.compliant, clock.stance
    angle, rate = estimate.joints[stance, 2], estimate.joint_rates[stance, 2]
    behind = np.arctan2(-posture.x[stance], -posture.z[stance]) - own.push_off_angle
    forward = capture_point(who, gravity, estimate) > posture.x[stance] and angle > -own.push_off_ankle
    share = min(max(behind / own.push_off_ramp, _ZERO), _ONE) if forward else _ZERO
    sole = posture.shank[stance] + angle
    left = angle + own.balance_ankle if error > 0 else own.balance_sole - sole
    flat = min(max(left / _BALANCE_RAMP, _ZERO), _ONE)
    resting = (
        own.ankle_stiffness * min(own.ankle_slack - angle, _ZERO) - own.ankle_capture_gain * error * flat
    )
    pushed = resting + share * (-push_off(who, estimate, clock.lag) - resting)
    return pushed - own.ankle_damping * rate + ankle_stop(who, angle)


def ankle_stop(who: Person, angle: np.float32) -> np.float32:
    """What keeps an ankle from plantarflexing further than people's do, N m."""
    own = who.gait.compliant
    return own.ankle_stop * max(-own.ankle_end - angle, _ZERO)
