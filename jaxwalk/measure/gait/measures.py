"""A gait in figures: each measured once a cycle, then summed up over strides, sides and walkers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from jaxwalk.config import GRAVITY
from jaxwalk.measure.gait import energy, signals
from jaxwalk.measure.gait.record import Ticks
from jaxwalk.measure.gait.strides import Cycle

UNITS = {
    "speed": "m/s",
    "cadence": "steps/min",
    "stride_length": "m",
    "step_length": "m",
    "stride_time": "s",
    "step_time": "s",
    "stance_share": "% of cycle",
    "double_support_share": "% of cycle",
    "hip_flexion_peak": "deg",
    "hip_extension_peak": "deg",
    "hip_excursion": "deg",
    "knee_flexion_loading": "deg",
    "knee_flexion_swing": "deg",
    "ankle_dorsiflexion_stance": "deg",
    "ankle_plantarflexion_peak": "deg",
    "torso_pitch_mean": "deg",
    "torso_pitch_excursion": "deg",
    "vertical_loading_peak": "BW",
    "vertical_trough": "BW",
    "vertical_push_peak": "BW",
    "braking_peak": "BW",
    "propulsion_peak": "BW",
    "impact_peak": "BW",
    "impact_peak_50_hz": "BW",
    "impact_impulse": "BW s",
    "hip_extensor_moment": "N m/kg",
    "hip_flexor_moment": "N m/kg",
    "knee_extensor_moment": "N m/kg",
    "knee_flexor_moment": "N m/kg",
    "ankle_plantarflexor_moment": "N m/kg",
    "hip_power_generated": "W/kg",
    "hip_power_absorbed": "W/kg",
    "knee_power_generated": "W/kg",
    "knee_power_absorbed": "W/kg",
    "ankle_power_generated": "W/kg",
    "ankle_power_absorbed": "W/kg",
    **energy.UNITS,
}
SYMMETRIC = (
    "step_length",
    "step_time",
    "stance_share",
    "hip_excursion",
    "knee_flexion_swing",
    "vertical_push_peak",
)
SYMMETRY = (
    "Symmetry index (Robinson, Herzog & Nigg 1987, J Manipulative Physiol Ther 10:172): "
    "100 (left - right) / (0.5 (left + right)) per cent, of each walker's means; 'mean' keeps the sign, "
    "'mean_size' does not. 0 is perfect symmetry."
)
LOADING = 0.3  # share of the cycle, from touch-down, in which the loaded knee gives
PLATE_CUTOFF = 50.0  # Hz; what a force plate's own filter may leave of a landing
LANDING_SECONDS = 0.02
IMPACT = (
    f"Impact peak: the largest vertical force, of single ticks (unfiltered) and through a low-pass of "
    f"{PLATE_CUTOFF:g} Hz; the loading peak beside it is that of the curve, {signals.CUTOFF:g} Hz. Impact "
    f"impulse: of the vertical force in the first {1000 * LANDING_SECONDS:g} ms on the floor, unfiltered. "
    "The shorter the contact's time constant (physics.contact_timeconst), the higher the peak of single "
    "ticks."
)


def of_cycle(
    ticks: Ticks, told: Mapping[str, Float[np.ndarray, "T 2"]], cycle: Cycle, timestep: float, mass: float
) -> dict[str, float]:
    """Each of `UNITS`. Moments and absorbed powers are sizes; the hip's extension peak and the
    ankle's plantarflexion peak are angles, negative where they are real extension and plantarflexion. The
    step's length is from where the other foot landed to where it lands itself.

    What the impact's figures are says `IMPACT`, the work's `energy.DEFINITION`.
    """
    side, whole = cycle.side, slice(cycle.start, cycle.stop)
    off = cycle.toe_off - cycle.start
    one = {name: values[whole, side] for name, values in told.items()}
    knee, vertical = one["knee_angle"], one["vertical_force"]
    seconds = cycle.ticks * timestep
    ankle = np.asarray(ticks.ankle_x, np.float64)
    length = float(ankle[cycle.stop, side] - ankle[cycle.start, side])
    weight = mass * GRAVITY
    # One stride on either side keeps the filter's ends out of sight.
    around = slice(max(0, 2 * cycle.start - cycle.stop), 2 * cycle.stop - cycle.start)
    upward = np.asarray(ticks.forces.ground[..., side, 1], np.float64) / weight
    plate = signals.low_pass(upward[around], timestep, PLATE_CUTOFF)
    plate = plate[cycle.start - around.start :][: cycle.ticks]
    return {
        "speed": length / seconds,
        "cadence": 120 / seconds,
        "stride_length": length,
        "step_length": float(ankle[cycle.stop, side] - ankle[cycle.other, 1 - side]),
        "stride_time": seconds,
        "step_time": (cycle.stop - cycle.other) * timestep,
        "stance_share": 100 * cycle.stance_share,
        "double_support_share": 100 * cycle.double_support,
        "hip_flexion_peak": one["hip_angle"].max(),
        "hip_extension_peak": one["hip_angle"].min(),
        "hip_excursion": np.ptp(one["hip_angle"]),
        "knee_flexion_loading": knee[: round(LOADING * cycle.ticks)].max(),
        "knee_flexion_swing": knee[off:].max(),
        "ankle_dorsiflexion_stance": one["ankle_angle"][:off].max(),
        "ankle_plantarflexion_peak": one["ankle_angle"].min(),
        "torso_pitch_mean": one["torso_pitch"].mean(),
        "torso_pitch_excursion": np.ptp(one["torso_pitch"]),
        "vertical_loading_peak": vertical[: off // 2].max(),
        "vertical_trough": vertical[round(0.3 * off) : round(0.7 * off)].min(),
        "vertical_push_peak": vertical[off // 2 : off].max(),
        "braking_peak": one["fore_aft_force"].min(),
        "propulsion_peak": one["fore_aft_force"].max(),
        "impact_peak": upward[whole].max(),
        "impact_peak_50_hz": plate.max(),
        "impact_impulse": upward[whole][: round(LANDING_SECONDS / timestep)].sum() * timestep,
        "hip_extensor_moment": one["hip_moment"].max(),
        "hip_flexor_moment": -one["hip_moment"].min(),
        "knee_extensor_moment": one["knee_moment"].max(),
        "knee_flexor_moment": -one["knee_moment"].min(),
        "ankle_plantarflexor_moment": one["ankle_moment"].max(),
        **{f"{joint}_power_generated": one[f"{joint}_power"].max() for joint in ("hip", "knee", "ankle")},
        **{f"{joint}_power_absorbed": -one[f"{joint}_power"].min() for joint in ("hip", "knee", "ankle")},
        **energy.of_cycle(ticks, told, cycle, length, timestep, mass),
    }


@dataclass(frozen=True)
class Measured:
    """All cycles of all walkers.

    Attributes:
      walker, side: [C] whose each is.
      values: [C] for each of `UNITS`.
    """

    walker: np.ndarray
    side: np.ndarray
    values: dict[str, Float[np.ndarray, "C"]]

    @classmethod
    def of(cls, rows: Sequence[tuple[int, int, Mapping[str, float]]]) -> Measured:
        """From (walker, side, `of_cycle`'s figures) of each cycle."""
        values = {name: np.array([row[2][name] for row in rows], np.float64) for name in UNITS}
        return cls(np.array([row[0] for row in rows]), np.array([row[1] for row in rows]), values)


def summary(measured: Measured) -> dict[str, dict[str, Any]]:
    """For each of `UNITS`: unit, mean and standard deviation over all cycles, and each side's mean."""
    found = {}
    for name, unit in UNITS.items():
        values = measured.values[name]
        sides = {side: values[measured.side == i].mean() for i, side in enumerate(("left", "right"))}
        found[name] = {"unit": unit, "mean": values.mean(), "sd": values.std(), **sides}
    return found


def symmetry(measured: Measured) -> dict[str, dict[str, float]]:
    """The symmetry index of each of `SYMMETRIC`, per cent; see `SYMMETRY`."""
    walkers = [w for w in np.unique(measured.walker) if set(measured.side[measured.walker == w]) == {0, 1}]
    found = {}
    for name in SYMMETRIC:
        means = [
            [
                measured.values[name][(measured.walker == walker) & (measured.side == side)].mean()
                for side in (0, 1)
            ]
            for walker in walkers
        ]
        index = np.array([symmetry_index(left, right) for left, right in means])
        found[name] = {"mean": index.mean(), "mean_size": np.abs(index).mean()}
    return found


def symmetry_index(left: float, right: float) -> float:
    """Robinson's symmetry index, per cent: 0 if both sides are alike, positive if the left is larger."""
    return 100 * (left - right) / (0.5 * (left + right))
