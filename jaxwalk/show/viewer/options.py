"""``jaxwalk view``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from jaxwalk.cli import checks
from jaxwalk.cli.parse import OptionalFloat, OptionalModel, Policy, parse


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
        """Raises:
        UserError: an option out of its range.
        """
        checks.policy(self.policy)
        checks.person(self.height, self.mass)
        if self.speed is not None:
            checks.between("--speed", self.speed, 0.1, 3.0, " m/s")
        checks.between("--noise", self.noise, 0.0, 100.0, "")
        checks.seed(self.seed)


def run(argv: Sequence[str]) -> None:
    args = parse(ViewArgs, argv, "view")
    args.check()

    from jaxwalk.common import runtime

    runtime.setup()
    from jaxwalk.show.viewer import command

    command.main(args)
