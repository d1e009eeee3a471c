"""``jaxwalk evaluate``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from jaxwalk.common import files
from jaxwalk.config import Engine
from jaxwalk.measure.protocol import PushTest
from jaxwalk.options import checks
from jaxwalk.options.parse import (
    Impulses,
    OptionalFile,
    OptionalFloat,
    OptionalInt,
    OptionalModel,
    Policy,
    checked,
)


@dataclass(frozen=True)
class EvaluateArgs:
    """Measure a policy: does it walk, which pushes does it survive, how soon is it steady again."""

    policy: Policy
    walkers: int = 256
    """Walkers in the test of undisturbed walking."""
    seconds: float = 60.0
    """How long they walk, s."""
    speed: float = 1.0
    """Forward speed that is asked for, m/s."""
    impulses: Impulses = (30.0, -40.0)
    """Pushes to try, N s, with commas between; positive ones push forward."""
    phases: int = 16
    """Points of the step at which a push begins, evenly spread."""
    replicas: OptionalInt = None
    """Walkers for each impulse and phase. Default: 128 where native code steps them, 8 elsewhere."""
    push_height: float = 0.0
    """Where the push lands, m above the torso's centre."""
    push_duration: float = 0.1
    """How long the push lasts, s."""
    height: OptionalFloat = None
    """Stature of all walkers, m. Default: that of the policy's configuration."""
    mass: OptionalFloat = None
    """Mass of all walkers, kg. Default: that of the policy's configuration."""
    model: OptionalModel = None
    noise: float = 1.0
    """Scale of the sensors' noise and bias: 1 realistic, 0 none."""
    engine: Engine = "mjx"
    """What moves the walkers: mjx, or mujoco (C MuJoCo in doubles, solved to convergence)."""
    seed: int = 0
    """Seed of everything that is drawn at random."""
    json: OptionalFile = None
    """File for the results, replaced if there. Default: a table on the screen only."""

    def check(self) -> None:
        """See that the options can be meant.

        Raises:
          UserError: an option out of its range.
        """
        checks.policy(self.policy)
        checks.between("--speed", self.speed, 0.1, 3.0, " m/s")
        checks.person(self.height, self.mass)
        checks.between("--noise", self.noise, 0.0, 100.0, "")
        PushTest.of(self).check()
        if self.json is not None:
            files.check_output("--json", self.json)


def read(argv: Sequence[str]) -> EvaluateArgs:
    """The options, checked.

    Raises:
      UserError: one of them is wrong.
    """
    return checked(EvaluateArgs, argv, "evaluate")
