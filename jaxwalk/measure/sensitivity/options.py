"""``jaxwalk sensitivity``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from jaxwalk.common import files
from jaxwalk.common.errors import UserError
from jaxwalk.config import Engine
from jaxwalk.measure.protocol import PushTest
from jaxwalk.options import checks
from jaxwalk.options.parse import Impulses, Numbers, Policy, checked


@dataclass(frozen=True)
class SensitivityArgs:
    """What a policy's results owe to the physics' settings: each is changed alone, the policy frozen.

    The policy's own settings are always among those tried.
    """

    policy: Policy
    out: Path
    """Folder for sensitivity.json and sensitivity.png, which are replaced if there."""
    timesteps: Numbers = (0.001, 0.0025)
    """Time steps, s; decisions keep their interval, and sensors their filters' time constants."""
    iterations: Numbers = (2.0, 4.0, 8.0)
    """Newton iterations a tick, at most. Not tried with mujoco, which iterates until it has converged."""
    contact_timeconsts: Numbers = (0.004, 0.01, 0.02)
    """Time constants of foot contact, s."""
    frictions: Numbers = (0.5, 0.7, 1.2)
    """Sliding frictions between sole and floor."""
    walkers: int = 64
    """Walkers in the test of undisturbed walking."""
    seconds: float = 15.0
    """How long they walk, s."""
    impulses: Impulses = (-50.0, -40.0, -30.0, 40.0, 50.0, 60.0, 70.0)
    """Pushes to try, N s, with commas between; positive ones push forward."""
    phases: int = 8
    """Points of the step at which a push begins, evenly spread."""
    replicas: int = 2
    """Walkers for each impulse and phase."""
    engine: Engine = "mjx"
    """What moves the walkers: mjx, or mujoco (C MuJoCo in doubles, solved to convergence)."""
    seed: int = 0
    """Seed of everything that is drawn at random."""

    def check(self) -> None:
        """See that the options can be meant.

        Raises:
          UserError: an option out of its range.
        """
        checks.policy(self.policy)
        for option in ("timesteps", "iterations", "contact_timeconsts", "frictions"):
            for value in getattr(self, option):
                checks.positive(f"--{option.replace('_', '-')}", value, "numbers")
        for value in self.timesteps:
            checks.between("--timesteps", value, 1e-4, 0.02, " s")
        for value in self.iterations:
            checks.between("--iterations", value, 1, 1000, "")
            if value != round(value):
                raise UserError(f"--iterations {value:g}: give whole numbers")
        PushTest.of(self).check()
        files.check_folder("--out", self.out)


def read(argv: Sequence[str]) -> SensitivityArgs:
    """The options, checked.

    Raises:
      UserError: one of them is wrong.
    """
    return checked(SensitivityArgs, argv, "sensitivity")
