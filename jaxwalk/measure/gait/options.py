"""``jaxwalk gait``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from jaxwalk.common import files
from jaxwalk.options import checks
from jaxwalk.options.parse import Numbers, OptionalActuators, OptionalFloat, Policy, checked


@dataclass(frozen=True)
class GaitArgs:
    """A gait report: joints, ground reaction, moments and powers over the stride, beside people's."""

    policy: Policy
    out: Path
    """Folder for gait.json, gait.csv and gait.png; another report there is left alone."""
    walkers: int = 32
    """Walkers, each with its own start and noise."""
    seconds: float = 20.0
    """How long they walk, s; the first 3 are not measured."""
    speed: float = 1.0
    """Forward speed that is asked for, m/s."""
    speeds: Numbers = ()
    """Further speeds, m/s, with commas between, at which steps and work are told beside people's."""
    height: OptionalFloat = None
    """Stature of all walkers, m. Default: that of the policy's configuration."""
    mass: OptionalFloat = None
    """Mass of all walkers, kg. Default: that of the policy's configuration."""
    actuators: OptionalActuators = None
    noise: float = 1.0
    """Scale of the sensors' noise and bias: 1 realistic, 0 none."""
    seed: int = 0
    """Seed of everything that is drawn at random."""

    def check(self) -> None:
        """See that the options can be meant.

        Raises:
          UserError: an option out of its range.
        """
        checks.policy(self.policy)
        checks.walkers("--walkers", self.walkers)
        checks.between("--seconds", self.seconds, 6.0, 3600.0, " s, the first 3 not being measured")
        checks.between("--speed", self.speed, 0.1, 3.0, " m/s")
        for speed in self.speeds:
            checks.between("--speeds", speed, 0.1, 3.0, " m/s")
        checks.person(self.height, self.mass)
        checks.between("--noise", self.noise, 0.0, 100.0, "")
        checks.seed(self.seed)
        files.check_folder("--out", self.out)


def read(argv: Sequence[str]) -> GaitArgs:
    """The options, checked.

    Raises:
      UserError: one of them is wrong.
    """
    return checked(GaitArgs, argv, "gait")
