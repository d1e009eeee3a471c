"""``jaxwalk view``."""

from __future__ import annotations

from dataclasses import dataclass

from jaxwalk.options import checks, shared
from jaxwalk.options.parse import OptionalActuators, OptionalFloat, OptionalModel, Policy, reader


@dataclass(frozen=True)
class ViewArgs:
    """Watch a policy walk in MuJoCo's viewer, in real time. Keys: left and right push backward and forward,
    up and down change the impulse, R starts anew, space pauses."""

    policy: Policy
    height: shared.OneStature = None
    mass: shared.OneMass = None
    speed: OptionalFloat = None
    """Forward speed that is asked for, m/s. Default: that of the policy's configuration."""
    model: OptionalModel = None
    actuators: OptionalActuators = None
    noise: shared.Noise = 1.0
    seed: int = 0
    """Seed of the first start and its noise; each start after it has the next."""

    def check(self) -> None:
        """As `Options.check`."""
        checks.policy(self.policy)
        checks.walker(self)
        checks.seed(self.seed)


read = reader(ViewArgs, "view")
