"""``jaxwalk agreement``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from jaxwalk.common import files
from jaxwalk.common.errors import UserError
from jaxwalk.measure.protocol import PushTest
from jaxwalk.options import checks, shared
from jaxwalk.options.parse import Policy, reader


@dataclass(frozen=True)
class AgreementArgs:
    """Whether MJX and another engine say the same of a policy: its walk, and survival push by push."""

    policy: Policy
    out: Path
    """Folder for agreement.json and agreement.png, which are replaced if there."""
    walkers: shared.Walkers = 128
    seconds: shared.Seconds = 30.0
    impulses: shared.TriedImpulses = (-60.0, -50.0, -40.0, -30.0, 40.0, 50.0, 60.0, 70.0, 80.0)
    phases: shared.Phases = 8
    replicas: shared.Replicas = 16
    height: shared.Stature = None
    mass: shared.Mass = None
    engine: shared.Engine = "mujoco"
    """What is set beside MJX: mujoco, ode or ode-quick."""
    seed: int = 0
    """Seed of everything that is drawn at random; both engines get the same."""

    def check(self) -> None:
        """As `Options.check`."""
        checks.policy(self.policy)
        checks.person(self.height, self.mass)
        PushTest.of(self).check()
        if self.engine == "mjx":
            raise UserError("--engine mjx: MJX is set beside another engine: give mujoco, ode or ode-quick")
        files.check_folder("--out", self.out)


read = reader(AgreementArgs, "agreement")
