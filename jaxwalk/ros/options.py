"""``jaxwalk ros``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from jaxwalk.common import files
from jaxwalk.options import checks
from jaxwalk.options.parse import Policy, reader


@dataclass(frozen=True)
class RosArgs:
    """Walk through ROS 1: a node that simulates the walker in ODE, one that controls it, a push, and a bag of
    all topics. It needs Debian's ROS and libode8."""

    policy: Policy
    out: Path
    """Folder for policy, body, report, logs and the bag; files of the same names are replaced."""
    seconds: float = 20.0
    """How long the walk lasts, s, simulated."""
    push: float = 0.0
    """Impulse of the push, N s; positive pushes forward, 0 is none."""
    push_time: float = 5.0
    """When the push begins, s."""
    lockstep: bool = True
    """Whether every tick waits for its command; otherwise time runs by the clock, as a robot's does."""
    factor: float = 1.0
    """Not in lock-step: simulated seconds a second."""
    step: Literal["world", "quick"] = "world"
    """ODE's step."""
    bag: bool = True
    """Whether a bag is recorded."""
    python: Path = Path("/usr/bin/python3")
    """The Python that has rospy."""
    seed: int = 0
    """Seed of the start."""

    def check(self) -> None:
        """As `Options.check`."""
        checks.policy(self.policy)
        checks.between("--seconds", self.seconds, 0.1, 3600.0, " s")
        checks.between("--push", self.push, -1000.0, 1000.0, " N s")
        checks.between("--push-time", self.push_time, 0.0, self.seconds, " s, within --seconds")
        checks.between("--factor", self.factor, 0.01, 100.0, "")
        checks.seed(self.seed)
        files.check_folder("--out", self.out)


read = reader(RosArgs, "ros")
