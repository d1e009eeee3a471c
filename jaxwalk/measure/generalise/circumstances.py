"""Circumstances that differ from a policy's own in one respect: body, load, floor, sensors or speed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from jaxwalk.common.errors import UserError
from jaxwalk.config import Config
from jaxwalk.learn.policies import named
from jaxwalk.learn.policies.named import Subject
from jaxwalk.measure.generalise.options import KINDS
from jaxwalk.model.burdens import BACKPACK, FRONT_PACK, Burden
from jaxwalk.model.similarity import Similarity


@dataclass(frozen=True)
class Circumstance:
    """One kind at one value, all else being the policy's own.

    Attributes:
      kind: of `KINDS`. value: in its unit. own: it is the policy's.
      speed: desired, m/s. height: m. mass: of the body, kg. noise: scale. They are known to the controllers.
      burden: which is not.
    """

    kind: str
    value: float
    own: bool
    speed: float
    height: float
    mass: float
    noise: float
    burden: Burden

    @property
    def kilograms(self) -> float:
        """All that moves, body and pack."""
        return self.mass + self.burden.mass

    def subject(self, name: str) -> Subject:
        """The policy called ``name``, in it but for the burden.

        Raises:
          UserError: it cannot walk there.
        """
        try:
            return named.load(name, speed=self.speed, height=self.height, mass=self.mass, noise=self.noise)
        except UserError as error:
            raise error if self.own else UserError(f"{KINDS[self.kind]} {self.value:g}: {error}") from None

    def push_ratio(self, own: Config) -> float:
        """What an impulse is multiplied by to be to this body what it is to the policy's own.

        A pack changes nothing: the same push meets the same person.
        """
        here, there = Similarity.of(self.height, self.mass), Similarity.of(own.body.height, own.body.mass)
        return here.impulse / there.impulse


def circumstances(config: Config, values: Mapping[str, Sequence[float]]) -> list[Circumstance]:
    """All that are tried, kind by kind, ascending, the policy's own among each.

    Args:
      config: the policy's own.
      values: for some of `KINDS`, in their order.
    """
    body, friction = config.body, config.physics.friction
    usual = {
        "speed": config.gait.speed_desired, "stature": body.height, "mass": body.mass,
        "noise": config.sensors.noise, "friction": friction, "force": 0.0, "backpack": 0.0, "front_pack": 0.0,
        "slope": 0.0, "delay": 0.0, "motor_strength": 1.0,
    }  # fmt: skip
    found = []
    if config.physics.actuators == "unlimited":  # whose motors have no strength of that kind
        values = {kind: tried for kind, tried in values.items() if kind != "motor_strength"}
    for kind, tried in values.items():
        for value in sorted({*tried, usual[kind]}):
            now = usual | {kind: value}
            # People of one shape weigh with the cube of their stature, as those of training do.
            mass = now["mass"] * (now["stature"] / body.height) ** 3
            pack, place = now["backpack"] or now["front_pack"], BACKPACK if now["backpack"] else FRONT_PACK
            burden = Burden(
                pack, *place, now["force"], now["friction"],
                math.radians(now["slope"]), now["motor_strength"], now["delay"],
            )  # fmt: skip
            own = value == usual[kind]
            found.append(
                Circumstance(kind, value, own, now["speed"], now["stature"], mass, now["noise"], burden)
            )
    return found
