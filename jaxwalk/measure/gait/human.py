"""What healthy people do on level ground, brought to the walkers' stature.

Most figures were computed from the workbook that Schwartz 2008 publishes, read for this: curves and cycle
events at free speed, dimensionless speed, cadence and step length. The children's mean stature and leg
length, which it leaves out, were read in the workbook of Pinzone 2014. What is of the walker's own speed was
computed from what van der Zee 2022 publishes for each person and trial.
Where there is no figure of people's, none could be read at its source.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from jaxwalk.config import GRAVITY

STATURE = 1.439  # m; Pinzone 2014, centre one: mean of 81 children
LEG = 0.749  # m; likewise
AT_SPEED = "van der Zee 2022"  # of `SOURCES`
ADULTS = 1.76  # m; van der Zee 2022
PREFERRED = (
    (0.7, 0.528, 0.050, 0.0626, 0.0104),
    (0.9, 0.607, 0.053, 0.0679, 0.0114),
    (1.1, 0.652, 0.052, 0.0770, 0.0128),
    (1.25, 0.693, 0.044, 0.0821, 0.0157),
    (1.4, 0.734, 0.042, 0.0922, 0.0116),
    (1.6, 0.809, 0.064, 0.0979, 0.0131),
    (1.8, 0.861, 0.062, 0.1102, 0.0131),
    (2.0, 0.896, 0.062, 0.1104, 0.0133),
)
"""Van der Zee's speeds, m/s; step length and its standard deviation, m; positive work by leg, J/(N m)."""

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
    "van der Zee 2022": "Van der Zee TJ, Mundinger EM, Kuo AD. A biomechanics dataset of healthy human "
    "walking at various speeds, step lengths and step widths. Sci Data 9:704, 2022; work and stride times "
    "of each trial as published beside its analysis (Wsoft). Nine adults at their preferred step on a "
    "treadmill, in proportion between two of eight speeds from 0.7 to 2.0 m/s, brought from their 1.76 m "
    "to the walkers' stature: people at the walkers' own speed. Work: the positive part of each leg's "
    "summed power.",
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


def people(height: float, speed: float) -> dict[str, Human]:
    """What people of ``height`` m do: at ``speed``, m/s, where that is known, else (`HUMAN`) at their own."""
    return {name: one.at(height) for name, one in (HUMAN | _at_speed(height, speed)).items()}


def at_own_speed(measure: Mapping[str, Any]) -> bool:
    """Whether people are told beside a ``measure`` (of `measures.summary`) who walk as fast as it is of."""
    return measure.get("human", {}).get("source") == AT_SPEED


def _at_speed(height: float, speed: float) -> dict[str, Human]:
    """Of people as tall as the children of `HUMAN`, at the speed that is similar to ``speed`` at ``height``;
    none beyond the speeds that were measured."""
    own = speed * math.sqrt(ADULTS / height)
    speeds, *columns = np.array(PREFERRED).T
    if not speeds[0] <= own <= speeds[-1]:
        return {}
    step, step_sd, work, work_sd = (float(np.interp(own, speeds, column)) for column in columns)
    shorter, longer = step - step_sd, step + step_sd
    source, share, cadence = AT_SPEED, STATURE / ADULTS, 60 * own * math.sqrt(ADULTS / STATURE)

    def length(steps: int) -> Human:
        told = (share * steps * x for x in (step, shorter, longer))
        return Human(*told, source=source, power=1.0)

    return {
        "step_length": length(1),
        "stride_length": length(2),
        "cadence": Human(cadence / step, cadence / longer, cadence / shorter, source=source, power=-0.5),
        "cost_of_transport_by_leg": Human(work, work - work_sd, work + work_sd, source=source),
    }


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
