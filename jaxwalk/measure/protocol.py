"""What a policy is put through by every measurement of pushes."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, get_args

from jaxwalk.common.errors import UserError
from jaxwalk.config import Config, Engine
from jaxwalk.options import checks


@dataclass(frozen=True)
class PushTest:
    """Unpushed walking, then pushes at points of the step.

    Attributes:
      walkers: unpushed. seconds: that they walk.
      impulses: of the pushes, N s, forward positive; none: walking alone.
      phases: points of the step at which a push begins, evenly spread.
      replicas: walkers for each impulse and phase; None: as many as the machine makes light of, see `sized`.
      push_height: where pushes land, m above the torso's centre. push_duration: how long they last, s.
      engine: what moves the walkers. seed: of all that is drawn at random.
    """

    walkers: int = 256
    seconds: float = 60.0
    impulses: tuple[float, ...] = (30.0, -40.0)
    phases: int = 16
    replicas: int | None = None
    push_height: float = 0.0
    push_duration: float = 0.1
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
        for option in ("walkers", "phases"):
            checks.whole(f"--{option}", getattr(self, option))
        checks.replicas(self.replicas)
        checks.between("--push-height", self.push_height, -1.0, 1.0, " m")
        checks.push_seconds("--push-duration", self.push_duration)
        if self.engine not in get_args(Engine):
            raise UserError(f"--engine {self.engine}: give one of {', '.join(get_args(Engine))}")
        checks.seed(self.seed)

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
