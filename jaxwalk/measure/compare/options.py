"""``jaxwalk compare``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from jaxwalk.common import files
from jaxwalk.config import Engine
from jaxwalk.measure.compare import groups
from jaxwalk.measure.protocol import PushTest
from jaxwalk.options import checks, shared
from jaxwalk.options.parse import (
    POLICIES,
    OptionalActuators,
    OptionalFloat,
    OptionalInt,
    OptionalModel,
    reader,
)

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
    walkers: shared.Walkers = 64
    seconds: shared.Seconds = 30.0
    speed: shared.Speed = 1.0
    impulses: shared.AscendingImpulses = IMPULSES
    phases: shared.Phases = 16
    replicas: OptionalInt = None
    """Walkers for each impulse and phase. Default: 128 where native code steps them, 4 elsewhere."""
    push_height: shared.PushHeight = 0.0
    push_duration: shared.PushDuration = 0.1
    push_again: shared.PushAgain = 0.0
    height: OptionalFloat = None
    """Stature of all walkers, m. Default: that of the policies' configuration."""
    mass: OptionalFloat = None
    """Mass of all walkers, kg. Default: that of the policies' configuration."""
    model: OptionalModel = None
    actuators: OptionalActuators = None
    noise: shared.Noise = 1.0
    slope: shared.Slope = 0.0
    delay: shared.Delay = 0.0
    motor_strength: shared.MotorStrength = 1.0
    engine: Engine = "mjx"
    """What moves the walkers: MJX, or C MuJoCo solved to convergence."""
    seed: shared.Seed = 0

    def check(self) -> None:
        """See that the options can be meant.

        Raises:
          UserError: an option out of its range, a policy that is missing, or a name given twice.
        """
        for one in groups.parse(self.policies):
            for member in one.members:
                checks.policy(member)
        checks.ascending("--impulses", self.impulses)
        checks.walker(self)
        PushTest.of(self).check()
        files.check_folder("--out", self.out)


read = reader(CompareArgs, "compare")
