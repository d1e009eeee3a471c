"""What healthy people do, level and at their own pace, brought to the walkers' stature.

All figures were computed from one data set, the workbook that Schwartz 2008 publishes, read for this:
curves and cycle events at free speed, dimensionless speed, cadence and step length. The children's mean
stature and leg length, which it leaves out, were read in the workbook of Pinzone 2014.
Where there is no figure of people's, none could be read at its source.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

from jaxwalk.config import GRAVITY

STATURE = 1.439  # m; Pinzone 2014, centre one: mean of 81 children
LEG = 0.749  # m; likewise

SOURCES = {
    "Schwartz 2008": "Schwartz MH, Rozumalski A, Trost JP. The effect of walking speed on the gait of "
    "typically developing children. J Biomech 41:1639-1650, 2008, supplementary workbook. 82 children, "
    "free speed. Peaks: extremes of the mean curve with the standard deviation there. Work: integrals of "
    "the mean power curves' positive and negative parts, which averaging makes smaller. Hip: less the "
    "pelvis's tilt, so that it is the thigh's angle to the vertical. Brought from the children's mean "
    "stature of 1.44 m and leg of 0.75 m (centre one of Pinzone O, Schwartz MH, Thomason P, Baker R. Gait"
    " Posture 40:286-290, 2014, whose powers are these to 0.05 W/kg) to the walkers' stature as similar "
    "bodies move: lengths and N m/kg grow with stature, speeds and W/kg with its root, cadence falls with"
    " its root.",
}


@dataclass(frozen=True)
class Human:
    """One published figure of healthy people.

    Attributes:
      mean: in the unit of the measure.
      low, high: mean less and plus one standard deviation; None: there is none.
      source: one of `SOURCES`.
      curve, percent: of which signal it is a point, and where in the cycle it is in people; None
        where it is none.
      sign: of the curve there, for measures that are sizes.
      power: of the stature, with which the figure grows.
    """

    mean: float
    low: float | None
    high: float | None
    source: str = "Schwartz 2008"
    curve: str | None = None
    percent: float | None = None
    sign: int = 1
    power: float = 0.0

    def at(self, height: float) -> Human:
        """The figure for people of ``height`` m, by similarity."""
        share = (height / STATURE) ** self.power
        ends = {end: None if value is None else share * value for end, value in self._ends.items()}
        return dataclasses.replace(self, mean=share * self.mean, **ends)

    @property
    def _ends(self) -> dict[str, float | None]:
        return {"low": self.low, "high": self.high}


def people(height: float) -> dict[str, Human]:
    """`HUMAN`, for people of ``height`` m."""
    return {name: one.at(height) for name, one in HUMAN.items()}


def _of(mean: float, sd: float, unit: float = 1.0, power: float = 0.0) -> Human:
    """The figure of a source that gives mean and standard deviation in multiples of ``unit``."""
    return Human(unit * mean, unit * (mean - sd), unit * (mean + sd), power=power)


def _curve(mean: float, sd: float, curve: str, percent: float, sign: int = 1, power: float = 0.0) -> Human:
    return dataclasses.replace(_of(mean, sd, power=power), curve=curve, percent=percent, sign=sign)


HUMAN = {
    "speed": _of(0.4294, 0.0259, unit=math.sqrt(GRAVITY * LEG), power=0.5),
    "cadence": _of(0.5648, 0.0374, unit=60 * math.sqrt(GRAVITY / LEG), power=-0.5),
    "step_length": _of(0.7596, 0.0437, unit=LEG, power=1.0),
    "stride_length": _of(0.7596, 0.0437, unit=2 * LEG, power=1.0),
    "stance_share": _of(59.0, 2.0),
    "double_support_share": _of(19.0, 2.0),
    "hip_flexion_peak": _curve(24.4, 5.5, "hip_angle", 90.0),
    "hip_extension_peak": _curve(-17.6, 6.8, "hip_angle", 52.0),
    "knee_flexion_loading": _curve(19.3, 6.3, "knee_angle", 12.0),
    "knee_flexion_swing": _curve(59.1, 5.9, "knee_angle", 72.0),
    "ankle_dorsiflexion_stance": _curve(11.8, 4.9, "ankle_angle", 46.0),
    "ankle_plantarflexion_peak": _curve(-19.8, 8.8, "ankle_angle", 64.0),
    "vertical_loading_peak": _curve(1.10, 0.13, "vertical_force", 14.0),
    "vertical_trough": _curve(0.79, 0.09, "vertical_force", 28.0),
    "vertical_push_peak": _curve(1.08, 0.11, "vertical_force", 46.0),
    "braking_peak": _curve(-0.162, 0.044, "fore_aft_force", 10.0),
    "propulsion_peak": _curve(0.190, 0.035, "fore_aft_force", 52.0),
    "hip_extensor_moment": _curve(0.73, 0.36, "hip_moment", 2.0, power=1.0),
    "hip_flexor_moment": _curve(0.62, 0.22, "hip_moment", 50.0, -1, power=1.0),
    "knee_extensor_moment": _curve(0.37, 0.23, "knee_moment", 12.0, power=1.0),
    "knee_flexor_moment": _curve(0.295, 0.173, "knee_moment", 2.0, -1, power=1.0),
    "ankle_plantarflexor_moment": _curve(1.23, 0.24, "ankle_moment", 48.0, power=1.0),
    "hip_power_generated": _curve(0.83, 0.41, "hip_power", 62.0, power=0.5),
    "hip_power_absorbed": _curve(0.41, 0.26, "hip_power", 44.0, -1, power=0.5),
    "knee_power_generated": _curve(0.69, 0.50, "knee_power", 2.0, power=0.5),
    "knee_power_absorbed": _curve(0.98, 0.40, "knee_power", 92.0, -1, power=0.5),
    "ankle_power_generated": _curve(2.80, 1.01, "ankle_power", 54.0, power=0.5),
    "ankle_power_absorbed": _curve(0.37, 0.48, "ankle_power", 40.0, -1, power=0.5),
    "cost_of_transport": Human(0.090, None, None),
    "cost_of_transport_filtered": Human(0.090, None, None),
    "hip_work_positive": Human(0.040, None, None),
    "hip_work_negative": Human(0.008, None, None),
    "knee_work_positive": Human(0.009, None, None),
    "knee_work_negative": Human(0.036, None, None),
    "ankle_work_positive": Human(0.041, None, None),
    "ankle_work_negative": Human(0.017, None, None),
}
"""By the names of `measures.UNITS`, for people of `STATURE`."""
