"""What a policy is put through by every measurement of pushes."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, get_args

from jaxwalk.common.errors import UserError
from jaxwalk.config import DELAY_MOST, Config, Engine
from jaxwalk.options import checks

if TYPE_CHECKING:
    from jaxwalk.model.burdens import Burden


@dataclass(frozen=True)
class PushTest:
    """Unpushed walking, then pushes at points of the step.

    Attributes:
      walkers: unpushed. seconds: that they walk.
      impulses: of the pushes, N s, forward positive; none: walking alone.
      phases: points of the step at which a push begins, evenly spread.
      replicas: walkers for each impulse and phase; None: as many as the machine makes light of, see `sized`.
      push_height: where pushes land, m above the torso's centre. push_duration: how long they last, s.
      push_again: s after its beginning that the same push comes a second time; 0: it does not.
      slope: of the floor, degrees, uphill positive. delay: by which instruments of torso and
        soles are told late, s.
      motor_strength: share of their strength that the motors have. Controllers are told of none
        of them, policies of the delay, where they observe it.
      engine: what moves the walkers. seed: of all that is drawn at random.
    """

    walkers: int = 256
    seconds: float = 60.0
    impulses: tuple[float, ...] = (30.0, -40.0)
    phases: int = 16
    replicas: int | None = None
    push_height: float = 0.0
    push_duration: float = 0.1
    push_again: float = 0.0
    slope: float = 0.0
    delay: float = 0.0
    motor_strength: float = 1.0
    engine: Engine = "mjx"
    seed: int = 0

    @classmethod
    def of(cls, options: Any) -> PushTest:
        """As a command's options of the same names say; what they do not have stands at its default."""
        names = [field.name for field in dataclasses.fields(cls) if hasattr(options, field.name)]
        return cls(**{name: getattr(options, name) for name in names})

    def check(self) -> None:
        """See that the test can be meant.

        Raises:
          UserError: a value out of its range, named as an option.
        """
        checks.impulses("--impulses", self.impulses)
        checks.walk_seconds(self.seconds)
        checks.walkers("--walkers", self.walkers)
        checks.whole("--phases", self.phases)
        checks.replicas(self.replicas)
        checks.walkers("--impulses x --phases x --replicas", self._pushed())
        checks.between("--push-height", self.push_height, -1.0, 1.0, " m")
        checks.push_seconds("--push-duration", self.push_duration)
        if self.push_again != 0:
            checks.between("--push-again", self.push_again, self.push_duration, 4.0, " s, or 0 for one push")
        checks.between("--slope", self.slope, -10.0, 10.0, " degrees")
        checks.between("--delay", self.delay, 0.0, DELAY_MOST, " s")
        checks.between("--motor-strength", self.motor_strength, 0.1, 1.0, "")
        if self.engine not in get_args(Engine):
            raise UserError(f"--engine {self.engine}: give one of {', '.join(get_args(Engine))}")
        checks.seed(self.seed)

    def _pushed(self) -> int:
        """Walkers that are pushed, or would be one in each cell; 1 at least."""
        return max(1, len(self.impulses) * self.phases * (self.replicas or 1))

    def burden(self, config: Config) -> Burden | None:
        """What its walkers bear; None where that is nothing.

        Raises:
          UserError: weak motors, where their strength is not limited.
        """
        if (self.slope, self.delay, self.motor_strength) == (0.0, 0.0, 1.0):
            return None
        if self.motor_strength != 1.0 and config.physics.actuators == "unlimited":
            raise UserError(
                f"--motor-strength {self.motor_strength:g}: the policy's motors are unlimited but for "
                "physics.hip_limit and its like: leave it out, or give --actuators person"
            )
        from jaxwalk.model.burdens import Burden  # which computes: options are read without it

        slope, friction = math.radians(self.slope), config.physics.friction
        return Burden(0.0, 0.0, 0.0, 0.0, friction, slope, self.motor_strength, self.delay)

    def sized(self, config: Config, many: int = 128, few: int = 8) -> PushTest:
        """With ``replicas``: ``many`` where native code steps walkers of ``config``, ``few`` elsewhere."""
        from jaxwalk.task import backend  # which computes: options are read without it

        return backend.sized(self, config, many, few)

    @property
    def cell(self) -> int:
        """Walkers for each impulse and phase.

        Raises:
          ValueError: they were left to `sized`.
        """
        if self.replicas is None:
            raise ValueError("a push test whose replicas are left open: ask `sized` for one that can be run")
        return self.replicas
