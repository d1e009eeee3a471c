"""``jaxwalk evaluate``."""

from __future__ import annotations

from dataclasses import dataclass

from jaxwalk.common import files
from jaxwalk.measure.protocol import PushTest
from jaxwalk.options import checks, shared
from jaxwalk.options.parse import OptionalActuators, OptionalFile, OptionalInt, OptionalModel, Policy, reader


@dataclass(frozen=True)
class EvaluateArgs:
    """Measure a policy: does it walk, which pushes does it survive, how soon is it steady again."""

    policy: Policy
    walkers: shared.Walkers = 256
    seconds: shared.Seconds = 60.0
    speed: shared.Speed = 1.0
    impulses: shared.TriedImpulses = (30.0, -40.0)
    phases: shared.Phases = 16
    replicas: OptionalInt = None
    """Walkers for each impulse and phase. Default: 128 where native code steps them, 8 elsewhere."""
    push_height: shared.PushHeight = 0.0
    push_duration: shared.PushDuration = 0.1
    push_again: shared.PushAgain = 0.0
    height: shared.Stature = None
    mass: shared.Mass = None
    model: OptionalModel = None
    actuators: OptionalActuators = None
    noise: shared.Noise = 1.0
    slope: shared.Slope = 0.0
    delay: shared.Delay = 0.0
    motor_strength: shared.MotorStrength = 1.0
    engine: shared.Engine = "mjx"
    seed: shared.Seed = 0
    json: OptionalFile = None
    """File for the results, replaced if there. Default: a table on the screen only."""

    def check(self) -> None:
        """As `Options.check`."""
        checks.policy(self.policy)
        checks.walker(self)
        PushTest.of(self).check()
        if self.json is not None:
            files.check_output("--json", self.json)


read = reader(EvaluateArgs, "evaluate")
