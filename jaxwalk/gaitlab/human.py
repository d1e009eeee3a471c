"""What healthy people do, level and at their own pace, with the sources.

Those of Schwartz 2008 were computed from its published data. Those of Perry 2010 and Collins 2005 were
written down from memory and have not been checked against the books: check them before citing.
Where a source gives no spread, there is none here.
"""

from __future__ import annotations

from dataclasses import dataclass

SOURCES = {
    "Perry 2010": "Perry J, Burnfield JM. Gait Analysis: Normal and Pathological Function. 2nd ed., "
    "Slack 2010. Adults; ranges are the means of women and of men.",
    "Schwartz 2008": "Schwartz MH, Rozumalski A, Trost JP. The effect of walking speed on the gait of "
    "typically developing children. J Biomech 41:1639-1650, 2008. Free speed; extremes of the mean curve "
    "with the standard deviation there. Children: moments for each kg grow with leg length, adults' are "
    "larger. Hip: less the pelvis's tilt, so that it is the thigh's angle to the vertical.",
    "Collins 2005": "Collins S, Ruina A, Tedrake R, Wisse M. Efficient bipedal robots based on "
    "passive-dynamic walkers. Science 307:1082-1085, 2005: people's mechanical cost of transport.",
}


@dataclass(frozen=True)
class Human:
    """One published figure.

    Attributes:
      mean: in the unit of the measure.
      low, high: mean less and plus one standard deviation, or the range that the source gives;
        None: it gives none.
      source: one of `SOURCES`.
      curve, percent: of which signal it is a point, and where in the cycle it is in people; None
        where it is none.
      sign: of the curve there, for measures that are sizes.
    """

    mean: float
    low: float | None
    high: float | None
    source: str
    curve: str | None = None
    percent: float | None = None
    sign: int = 1


def _perry(
    mean: float,
    low: float | None = None,
    high: float | None = None,
    curve: str | None = None,
    percent: float | None = None,
) -> Human:
    return Human(mean, low, high, "Perry 2010", curve, percent)


def _schwartz(mean: float, sd: float, curve: str, percent: float, sign: int = 1) -> Human:
    return Human(mean, mean - sd, mean + sd, "Schwartz 2008", curve, percent, sign)


HUMAN = {
    "speed": _perry(1.37, 1.28, 1.43),
    "cadence": _perry(113.0, 111.0, 117.0),
    "stride_length": _perry(1.41, 1.28, 1.46),
    "stance_share": _perry(0.60),
    "double_support_share": _perry(0.20),
    "hip_flexion_peak": _schwartz(24.4, 5.5, "hip_angle", 90.0),
    "hip_extension_peak": _schwartz(-17.6, 6.8, "hip_angle", 52.0),
    "knee_flexion_loading": _schwartz(19.3, 6.3, "knee_angle", 12.0),
    "knee_flexion_swing": _schwartz(59.1, 5.9, "knee_angle", 72.0),
    "ankle_dorsiflexion_stance": _schwartz(11.8, 4.9, "ankle_angle", 46.0),
    "ankle_plantarflexion_peak": _schwartz(-19.8, 8.8, "ankle_angle", 64.0),
    "vertical_loading_peak": _perry(1.1, curve="vertical_force", percent=12.0),
    "vertical_trough": _perry(0.8, curve="vertical_force", percent=31.0),
    "vertical_push_peak": _perry(1.1, curve="vertical_force", percent=50.0),
    "hip_extensor_moment": _schwartz(0.73, 0.36, "hip_moment", 2.0),
    "hip_flexor_moment": _schwartz(0.62, 0.22, "hip_moment", 50.0, -1),
    "knee_extensor_moment": _schwartz(0.37, 0.23, "knee_moment", 12.0),
    "knee_flexor_moment": _schwartz(0.29, 0.17, "knee_moment", 2.0, -1),
    "ankle_plantarflexor_moment": _schwartz(1.23, 0.24, "ankle_moment", 48.0),
    "hip_power_generated": _schwartz(0.83, 0.41, "hip_power", 62.0),
    "hip_power_absorbed": _schwartz(0.41, 0.26, "hip_power", 44.0, -1),
    "knee_power_generated": _schwartz(0.69, 0.50, "knee_power", 2.0),
    "knee_power_absorbed": _schwartz(0.98, 0.40, "knee_power", 92.0, -1),
    "ankle_power_generated": _schwartz(2.80, 1.01, "ankle_power", 54.0),
    "ankle_power_absorbed": _schwartz(0.37, 0.48, "ankle_power", 40.0, -1),
    "cost_of_transport": Human(0.05, None, None, "Collins 2005"),
}
"""By the names of `measures.UNITS`."""
