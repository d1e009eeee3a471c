"""Anthropometry: from (height, mass, table) to the segments of a human body."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from jaxwalk.config import BodyConfig, validate

# Winter, Biomechanics and Motor Control of Human Movement: lengths as fractions of height.
FOOT_HEIGHT, SHANK, THIGH = 0.039, 0.246, 0.245
HIP_TO_CROWN, HIP_TO_SHOULDER, FOOT_LENGTH = 0.470, 0.288, 0.152
# The part of the foot that bears load, from the ankle, at 1.8 m: heel -0.06 m, toe +0.15 m.
HEEL, TOE = -0.06 / 1.8, 0.15 / 1.8

# (mass fraction, centre of mass from the proximal end, radius of gyration), the last two
# as fractions of the segment's reference length.
WINTER = {
    "torso": (0.678, 0.626, 0.496),
    "thigh": (0.100, 0.433, 0.323),
    "shank": (0.0465, 0.433, 0.302),
    "foot": (0.0145, 0.500, 0.475),
}
_ROD = math.sqrt(1.0 / 12.0)  # radius of gyration of a uniform rod about its middle
BOX = {name: (row[0], 0.5, _ROD) for name, row in WINTER.items()}


@dataclass(frozen=True)
class Segment:
    """One rigid segment.

    Attributes:
      mass: kg.
      length: m, joint to joint (torso: hip to crown; foot: ankle height).
      com: (x, z) of the centre of mass from the proximal joint, m; z up.
      inertia: about the centre of mass, pitch axis, kg m^2.
    """

    mass: float
    length: float
    com: tuple[float, float]
    inertia: float


@dataclass(frozen=True)
class Body:
    """The seven segments (legs alike) and the sole.

    Attributes:
      height, mass: m, kg.
      heel, toe: x of the sole's ends from the ankle, m.
    """

    height: float
    mass: float
    torso: Segment
    thigh: Segment
    shank: Segment
    foot: Segment
    heel: float
    toe: float

    @property
    def hip_height(self) -> float:
        """Hip above the floor when standing straight, m (``L`` of the paper)."""
        return self.thigh.length + self.shank.length + self.foot.length


def masses(body: Body) -> np.ndarray:
    """[7] of torso, then thigh, shank and foot, left and right, kg."""
    leg = [body.thigh.mass, body.shank.mass, body.foot.mass]
    return np.array([body.torso.mass, *leg, *leg], np.float32)


def build(config: BodyConfig) -> Body:
    """Scale a table to one person.

    Raises:
      UserError: no such person, see `validate.person`.
    """
    validate.person(config)
    h, m = config.height, config.mass
    rows = {"winter": WINTER, "box": BOX}[config.table]

    def limb(name: str, length: float) -> Segment:
        fraction, com, gyration = rows[name]
        return Segment(fraction * m, length, (0.0, -com * length), fraction * m * (gyration * length) ** 2)

    fraction, com, gyration = rows["torso"]
    # Winter measures HAT against hip-to-shoulder; a uniform box fills hip to crown.
    reference = (HIP_TO_SHOULDER if config.table == "winter" else HIP_TO_CROWN) * h
    torso = Segment(
        fraction * m, HIP_TO_CROWN * h, (0.0, com * reference), fraction * m * (gyration * reference) ** 2
    )
    fraction, _, gyration = rows["foot"]
    foot = Segment(
        fraction * m,
        FOOT_HEIGHT * h,
        (0.5 * (HEEL + TOE) * h, -0.5 * FOOT_HEIGHT * h),
        fraction * m * (gyration * FOOT_LENGTH * h) ** 2,
    )
    return Body(
        height=h,
        mass=m,
        torso=torso,
        thigh=limb("thigh", THIGH * h),
        shank=limb("shank", SHANK * h),
        foot=foot,
        heel=HEEL * h,
        toe=TOE * h,
    )


def about_joint(segment: Segment) -> float:
    """The segment's inertia about its proximal joint, kg m^2."""
    return segment.inertia + segment.mass * (segment.com[0] ** 2 + segment.com[1] ** 2)
