"""``jaxwalk push-map``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import get_args

from jaxwalk.common import files
from jaxwalk.common.errors import UserError
from jaxwalk.config import Engine
from jaxwalk.model.push_points import Point
from jaxwalk.options import checks, shared
from jaxwalk.options.parse import (
    Numbers,
    OptionalActuators,
    OptionalInt,
    OptionalModel,
    Points,
    Policy,
    reader,
)

IMPULSES = tuple(float(i) for i in range(-120, 121, 15))


@dataclass(frozen=True)
class PushMapArgs:
    """Which pushes a policy survives: phase of the step x impulse x point x duration."""

    policy: Policy
    out: Path
    """Folder for map.npz, map.json and map.png. A map that was interrupted there goes on."""
    impulses: shared.AscendingImpulses = IMPULSES
    phases: shared.Phases = 16
    points: Points = ("torso",)
    """Where pushes land, with commas between: torso (its centre), torso+0.2 (0.2 m above), torso-0.1, or
    the centre of stance-thigh, stance-shank, swing-thigh, swing-shank; stance is the leg that carries when
    the push begins."""
    durations: Numbers = (0.1,)
    """How long pushes last, s, with commas between."""
    replicas: OptionalInt = None
    """Walkers for each combination. Default: 64 where native code steps them, 8 elsewhere."""
    chunk: int = 512
    """Trials in one program: what bounds the memory. The map does not depend on it, nor on how many devices
    there are (on a GPU programs of other sizes round otherwise, which can turn a trial on the brink)."""
    model: OptionalModel = None
    actuators: OptionalActuators = None
    engine: shared.Engine = "mjx"
    seed: shared.Seed = 0

    def check(self) -> None:
        """As `Options.check`."""
        checks.policy(self.policy)
        checks.ascending("--impulses", self.impulses)
        checks.ascending("--durations", self.durations)
        for impulse in self.impulses:
            checks.between("--impulses", impulse, -1000.0, 1000.0, " N s")
        if len(set(self.points)) < len(self.points):
            raise UserError(f"--points {','.join(self.points)}: give each point once")
        for point in self.points:
            checks.between("--points torso", _point(point).height, -1.0, 1.0, " m above its centre")
        for duration in self.durations:
            checks.push_seconds("--durations", duration)
        checks.replicas(self.replicas)
        for option in ("phases", "chunk"):
            checks.whole(f"--{option}", getattr(self, option))
        cells = len(self.impulses) * self.phases * len(self.points) * len(self.durations)
        every = "--impulses x --phases x --points x --durations x --replicas"
        checks.walkers(every, max(1, cells * (self.replicas or 1)))
        if self.engine not in get_args(Engine):
            raise UserError(f"--engine {self.engine}: give one of {', '.join(get_args(Engine))}")
        checks.seed(self.seed)
        files.check_folder("--out", self.out)


def _point(name: str) -> Point:
    try:
        return Point.of(name)
    except ValueError as error:
        raise UserError(f"--points {error}") from None


read = reader(PushMapArgs, "push-map")
