"""``jaxwalk compare``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from jaxwalk.common import files
from jaxwalk.config import Engine
from jaxwalk.measure.compare import groups
from jaxwalk.measure.protocol import PushTest
from jaxwalk.options import checks
from jaxwalk.options.parse import POLICIES, Impulses, OptionalFloat, OptionalInt, OptionalModel, checked

IMPULSES = tuple(float(i) for i in (*range(-60, -10, 10), *range(20, 90, 10)))
Policies = Annotated[
    tuple[str, ...],
    tyro.conf.Positional,
    tyro.conf.arg(
        metavar="POLICY|NAME=RUN,RUN", help=f"{POLICIES} Or the seeds of one method as NAME=RUN,RUN."
    ),
]


@dataclass(frozen=True)
class CompareArgs:
    """Measure several policies, with their seeds, on the same starts, noise and pushes."""

    policies: Policies
    out: Path
    """Folder for compare.json, compare.csv and compare.png, which are replaced if there."""
    walkers: int = 64
    """Walkers in the test of undisturbed walking."""
    seconds: float = 30.0
    """How long they walk, s."""
    speed: float = 1.0
    """Forward speed that is asked for, m/s."""
    impulses: Impulses = IMPULSES
    """Pushes, N s, ascending, with commas between; positive ones push forward."""
    phases: int = 16
    """Points of the step at which a push begins, evenly spread."""
    replicas: OptionalInt = None
    """Walkers for each impulse and phase. Default: 128 where native code steps them, 4 elsewhere."""
    push_height: float = 0.0
    """Where the push lands, m above the torso's centre."""
    push_duration: float = 0.1
    """How long the push lasts, s."""
    height: OptionalFloat = None
    """Stature of all walkers, m. Default: that of the policies' configuration."""
    mass: OptionalFloat = None
    """Mass of all walkers, kg. Default: that of the policies' configuration."""
    model: OptionalModel = None
    noise: float = 1.0
    """Scale of the sensors' noise and bias: 1 realistic, 0 none."""
    engine: Engine = "mjx"
    """What moves the walkers: MJX, or C MuJoCo solved to convergence."""
    seed: int = 0
    """Seed of everything that is drawn at random."""

    def check(self) -> None:
        """See that the options can be meant.

        Raises:
          UserError: an option out of its range, a policy that is missing, or a name given twice.
        """
        for one in groups.parse(self.policies):
            for member in one.members:
                checks.policy(member)
        checks.between("--speed", self.speed, 0.1, 3.0, " m/s")
        checks.ascending("--impulses", self.impulses)
        checks.person(self.height, self.mass)
        checks.between("--noise", self.noise, 0.0, 100.0, "")
        PushTest.of(self).check()
        files.check_folder("--out", self.out)


def read(argv: Sequence[str]) -> CompareArgs:
    """The options, checked.

    Raises:
      UserError: one of them is wrong.
    """
    return checked(CompareArgs, argv, "compare")
