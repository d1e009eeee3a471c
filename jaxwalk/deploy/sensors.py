"""From the instruments to what the controllers are told: a moving mean and a Kalman filter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from jaxwalk.deploy.kinematics import Posture
from jaxwalk.deploy.person import Person


@dataclass(frozen=True)
class Sensors:
    """What the instruments say after a tick.

    Attributes:
      velocity, acceleration: forward, of the torso's centre, m/s and m/s^2.
      pitch, pitch_rate: of the torso, forward positive, rad and rad/s.
      joints, joint_rates: [2, 3] hip, knee, ankle; left, right; flexion, dorsiflexion positive; rad, rad/s.
      touch: [2] force under the left and right sole, N.
    """

    velocity: float | np.floating
    acceleration: float | np.floating
    pitch: float | np.floating
    pitch_rate: float | np.floating
    joints: np.ndarray
    joint_rates: np.ndarray
    touch: np.ndarray


SILENT = Sensors(0.0, 0.0, 0.0, 0.0, np.zeros((2, 3)), np.zeros((2, 3)), np.zeros(2))
"""What instruments say that have said nothing yet."""


@dataclass(frozen=True)
class Estimate:
    """What controllers and policy are told: as `Sensors`, float32, speed and acceleration filtered."""

    speed: np.float32
    acceleration: np.float32
    pitch: np.float32
    pitch_rate: np.float32
    joints: np.ndarray
    joint_rates: np.ndarray
    touch: np.ndarray


@dataclass(frozen=True)
class Filter:
    """Memory of the filters.

    Attributes:
      gain: [2, 2] of the Kalman filter. timestep: s.
      history: [N, 2] the last N (velocity, acceleration).
      filtered: [2] the Kalman filter's velocity and acceleration.
    """

    gain: np.ndarray
    timestep: np.float32
    history: np.ndarray
    filtered: np.ndarray


def start(manifest: dict[str, Any], speed: np.float32) -> Filter:
    """Filters at rest on a walker that moves at ``speed`` m/s."""
    settled = np.array([speed, 0], np.float32)
    return Filter(
        gain=np.array(manifest["sensors"]["kalman_gain"], np.float32),
        timestep=np.float32(manifest["timestep"]),
        history=np.tile(settled, (manifest["sensors"]["mean_window"], 1)),
        filtered=settled,
    )


def step(state: Filter, sensors: Sensors) -> tuple[Filter, Estimate]:
    """The filters after one more tick, and what controllers and policy are told in it."""
    measured = np.array([[sensors.velocity, sensors.acceleration]], np.float32)
    history = np.concatenate([state.history[1:], measured])
    prior = np.array([state.filtered[0] + state.timestep * state.filtered[1], state.filtered[1]])
    filtered = prior + state.gain @ (history.mean(axis=0) - prior)
    return Filter(state.gain, state.timestep, history, filtered), estimate(sensors, filtered)


def estimate(sensors: Sensors, filtered: np.ndarray) -> Estimate:
    """The instruments' values with [2] filtered velocity and acceleration."""
    return Estimate(
        speed=filtered[0],
        acceleration=filtered[1],
        pitch=np.float32(sensors.pitch),
        pitch_rate=np.float32(sensors.pitch_rate),
        joints=np.asarray(sensors.joints, np.float32),
        joint_rates=np.asarray(sensors.joint_rates, np.float32),
        touch=np.asarray(sensors.touch, np.float32),
    )


def com_ahead(
    who: Person, posture: Posture, estimate: Estimate, stance: int
) -> tuple[np.float32, np.float32]:
    """(x ahead of the stance ankle, z above its sole) of the torso's centre, m."""
    ahead = who.torso * np.sin(estimate.pitch) - posture.x[stance]
    return ahead, who.torso * np.cos(estimate.pitch) - posture.z[stance] + who.foot


def zmp_distance(
    who: Person, gravity: np.float32, posture: Posture, estimate: Estimate, stance: int
) -> np.float32:
    """How far the zero-moment point lies ahead of the stance ankle, m (eq. 4)."""
    com_x, com_z = com_ahead(who, posture, estimate, stance)
    return com_x - estimate.acceleration / gravity * com_z


def capture_point(who: Person, gravity: np.float32, estimate: Estimate) -> np.float32:
    """Where a foot would bring the body to rest, m ahead of the hip."""
    lean = who.torso_share * who.torso * np.sin(estimate.pitch)
    return lean + estimate.speed * np.sqrt(who.leg / gravity)
