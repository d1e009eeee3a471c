"""The quantities of a gait report, tick by tick, in the units and signs of gait analysis."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from scipy import signal

from jaxwalk.config import GRAVITY
from jaxwalk.measure.gait.record import Ticks

JOINTS = ("hip", "knee", "ankle")
CUTOFF = 15.0
"""Hz; forces, moments and powers pass a zero-lag low-pass filter (4th order Butterworth), as gait
laboratories' do; people's curves beside them have 51 points a stride, which tell nothing above 25 Hz."""

UNITS = {
    **{f"{joint}_angle": "deg" for joint in JOINTS},
    "torso_pitch": "deg",
    "vertical_force": "BW",
    "fore_aft_force": "BW",
    **{f"{joint}_moment": "N m/kg" for joint in JOINTS},
    **{f"{joint}_power": "W/kg" for joint in JOINTS},
}
CONVENTIONS = (
    "Hip and knee flexion, ankle dorsiflexion are positive; the hip's angle is the thigh's to the vertical, "
    "as people's beside it, whatever torso or pelvis lean; 0 at the ankle is a right angle between shank "
    "and sole. Torso pitch: forward lean positive. "
    "Forces: those of the ground on the foot, upward and forward (propulsion) positive. Moments: internal, "
    "extension and plantarflexion positive, actuator and passive damping together. Powers: of those "
    f"moments, generation positive. Forces, moments and powers: low-pass, {CUTOFF:g} Hz, zero lag (which "
    "smears a landing to both sides). BW: multiples of the walker's own weight. "
    "Cycle: from touch-down to the next touch-down of the same leg, 0 to 100 per cent."
)


def low_pass(
    values: Float[np.ndarray, "T *Q"], timestep: float, cutoff: float = CUTOFF
) -> Float[np.ndarray, "T *Q"]:
    """Without what is faster than ``cutoff`` Hz; means are kept."""
    # Forward and backward: twice the second order, and a cutoff that is corrected for the two passes.
    corrected = cutoff / (np.sqrt(2) - 1) ** 0.25
    if 2 * corrected * timestep >= 1:
        return values  # ticks that long hold nothing faster
    sections = signal.butter(2, corrected, fs=1 / timestep, output="sos")
    return signal.sosfiltfilt(sections, values, axis=0)


def of_walker(ticks: Ticks, timestep: float, mass: float) -> dict[str, Float[np.ndarray, "T 2"]]:
    """Each of `UNITS`, [T, 2] for left and right, of one walker's recording [T]."""
    told = ticks.forces
    torque = np.array(told.torque, np.float64)
    torque[..., 2] += told.damping
    moment = low_pass(-torque / mass, timestep)
    power = low_pass(torque * np.asarray(told.rates, np.float64) / mass, timestep)
    ground = low_pass(np.asarray(told.ground, np.float64) / (mass * GRAVITY), timestep)
    angles = np.degrees(np.asarray(ticks.joints))
    found = {f"{joint}_angle": angles[..., i] for i, joint in enumerate(JOINTS)}
    found["hip_angle"] = angles[..., 0] - np.degrees(np.asarray(ticks.pitch))[:, None]
    found["torso_pitch"] = np.repeat(np.degrees(np.asarray(ticks.pitch))[:, None], 2, axis=1)
    found["vertical_force"], found["fore_aft_force"] = ground[..., 1], ground[..., 0]
    found |= {f"{joint}_moment": moment[..., i] for i, joint in enumerate(JOINTS)}
    return found | {f"{joint}_power": power[..., i] for i, joint in enumerate(JOINTS)}
