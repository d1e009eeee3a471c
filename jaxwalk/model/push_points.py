"""Where on the body a push lands, as it is called on the command line and in files."""

from __future__ import annotations

import math
from dataclasses import dataclass

PLACES = ("torso", "stance-thigh", "stance-shank", "swing-thigh", "swing-shank")
"""Segments that can be pushed; the stance leg is the one that carries when the push begins."""


@dataclass(frozen=True)
class Point:
    """One point on the body.

    Attributes:
      place: one of `PLACES`; a segment of a leg is pushed at its own centre of mass.
      height: above the torso's centre, m; 0 on a leg.
    """

    place: str
    height: float = 0.0

    @classmethod
    def of(cls, text: str) -> Point:
        """``torso``, ``torso+0.2`` (0.2 m above its centre), ``torso-0.1``, or a segment of a leg.

        Raises:
          ValueError: it is none of them.
        """
        name = text.strip()
        if name in PLACES:
            return cls(name)
        try:
            above = float(name.removeprefix("torso"))
        except ValueError:
            above = math.nan
        if not name.startswith(("torso+", "torso-")) or not math.isfinite(above):
            known = ", ".join(PLACES[1:])
            raise ValueError(f"{name!r} is no point on the body, give torso, torso+0.2 (m above), {known}")
        return cls("torso", above + 0.0)  # no -0

    @property
    def name(self) -> str:
        """The text that `of` makes this point of."""
        return f"{self.place}{self.height:+g}" if self.height else self.place

    @property
    def words(self) -> str:
        """For the title of a picture."""
        if self.place == "torso":
            return f"torso, {self.height:+g} m from its centre" if self.height else "torso's centre"
        leg, segment = self.place.split("-")
        return f"{segment} of the {leg} leg"

    @property
    def on_torso(self) -> bool:
        """Whether it is on the torso, where heights count."""
        return self.place == PLACES[0]
