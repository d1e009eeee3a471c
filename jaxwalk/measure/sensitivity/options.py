"""``jaxwalk sensitivity``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from jaxwalk.common import files
from jaxwalk.common.errors import UserError
from jaxwalk.measure.protocol import PushTest
from jaxwalk.options import checks, shared
from jaxwalk.options.parse import Numbers, Policy, reader


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
    walkers: shared.Walkers = 64
    seconds: shared.Seconds = 15.0
    impulses: shared.TriedImpulses = (-50.0, -40.0, -30.0, 40.0, 50.0, 60.0, 70.0)
    phases: shared.Phases = 8
    replicas: shared.Replicas = 2
    engine: shared.Engine = "mjx"
    seed: shared.Seed = 0

    def check(self) -> None:
        """As `Options.check`."""
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


read = reader(SensitivityArgs, "sensitivity")
