"""``jaxwalk view``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from jaxwalk.options import checks
from jaxwalk.options.parse import OptionalFloat, OptionalModel, Policy, checked


@dataclass(frozen=True)
class ViewArgs:
    """Watch a policy walk in MuJoCo's viewer, in real time. Keys: left and right push backward and forward,
    up and down change the impulse, R starts anew, space pauses."""

    policy: Policy
    height: OptionalFloat = None
    """Stature, m. Default: that of the policy's configuration."""
    mass: OptionalFloat = None
    """Mass, kg. Default: that of the policy's configuration."""
    speed: OptionalFloat = None
    """Forward speed that is asked for, m/s. Default: that of the policy's configuration."""
    model: OptionalModel = None
    noise: float = 1.0
    """Scale of the sensors' noise and bias: 1 realistic, 0 none."""
    seed: int = 0
    """Seed of the first start and its noise; each start after it has the next."""

    def check(self) -> None:
        """See that the options can be meant.

        Raises:
          UserError: an option out of its range.
        """
        checks.policy(self.policy)
        checks.person(self.height, self.mass)
        if self.speed is not None:
            checks.between("--speed", self.speed, 0.1, 3.0, " m/s")
        checks.between("--noise", self.noise, 0.0, 100.0, "")
        checks.seed(self.seed)


def read(argv: Sequence[str]) -> ViewArgs:
    """The options, checked.

    Raises:
      UserError: one of them is wrong.
    """
    return checked(ViewArgs, argv, "view")
