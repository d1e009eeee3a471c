"""``jaxwalk agreement``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from jaxwalk.common import files
from jaxwalk.measure.protocol import PushTest
from jaxwalk.options import checks
from jaxwalk.options.parse import Impulses, OptionalFloat, Policy, checked


@dataclass(frozen=True)
class AgreementArgs:
    """Whether MJX and C MuJoCo say the same of a policy: its walk, and survival push by push."""

    policy: Policy
    out: Path
    """Folder for agreement.json and agreement.png, which are replaced if there."""
    walkers: int = 128
    """Walkers in the test of undisturbed walking."""
    seconds: float = 30.0
    """How long they walk, s."""
    impulses: Impulses = (-60.0, -50.0, -40.0, -30.0, 40.0, 50.0, 60.0, 70.0, 80.0)
    """Pushes to try, N s, with commas between; positive ones push forward."""
    phases: int = 8
    """Points of the step at which a push begins, evenly spread."""
    replicas: int = 16
    """Walkers for each impulse and phase."""
    height: OptionalFloat = None
    """Stature of all walkers, m. Default: that of the policy's configuration."""
    mass: OptionalFloat = None
    """Mass of all walkers, kg. Default: that of the policy's configuration."""
    seed: int = 0
    """Seed of everything that is drawn at random; both engines get the same."""

    def check(self) -> None:
        """See that the options can be meant.

        Raises:
          UserError: an option out of its range.
        """
        checks.policy(self.policy)
        checks.person(self.height, self.mass)
        PushTest.of(self).check()
        files.check_folder("--out", self.out)


def read(argv: Sequence[str]) -> AgreementArgs:
    """The options, checked.

    Raises:
      UserError: one of them is wrong.
    """
    return checked(AgreementArgs, argv, "agreement")
