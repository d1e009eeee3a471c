"""``jaxwalk generalise``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from jaxwalk.common import files
from jaxwalk.common.errors import UserError
from jaxwalk.config import DELAY_MOST
from jaxwalk.measure.protocol import PushTest
from jaxwalk.options import checks, shared
from jaxwalk.options.parse import Impulses, Names, Numbers, Policy, reader

KINDS = {  # of circumstances -> its option
    "stature": "--statures",
    "mass": "--masses",
    "backpack": "--backpacks",
    "front_pack": "--front-packs",
    "force": "--forces",
    "friction": "--frictions",
    "slope": "--slopes",
    "delay": "--delays",
    "motor_strength": "--motor-strengths",
    "noise": "--noises",
    "speed": "--speeds",
}
NOBODY = "none"


@dataclass(frozen=True)
class GeneraliseArgs:
    """How far a frozen policy generalises: bodies, loads, floors, motors, sensors, speeds, each alone.

    The policy's own circumstances are always among those tried. The controllers know stature, mass and
    speed; of packs, forces, floors, motors and noise they are not told, and of delays the policy alone.
    """

    policy: Policy
    out: Path
    """Folder for generalise.json, .csv and .png, which are replaced if there."""
    beside: str = "fixed"
    """Another POLICY put through the same; 'none' for nobody."""
    only: Names = ()
    """Kinds to try, with commas between: stature, mass, backpack, front_pack, force, friction, slope, delay,
    motor_strength, noise, speed. Default: all."""
    statures: Numbers = (1.4, 1.6, 2.0, 2.3)
    """Statures, m; mass goes with the cube, and the pushes with the body."""
    masses: Numbers = (100.0,)
    """Masses at one stature, kg; the pushes go with them."""
    backpacks: Numbers = (10.0, 20.0)
    """Masses of a pack on the back, kg."""
    front_packs: Numbers = (10.0, 25.0)
    """Masses of a pack in front, kg."""
    forces: Numbers = (-30.0, 30.0)
    """Steady horizontal forces on the torso, N; positive ones push forward. 30 N on 75 kg: a slope of 4 %."""
    frictions: Numbers = (0.3, 0.5)
    """Sliding frictions between sole and floor."""
    slopes: Numbers = (-3.0, 3.0)
    """Slopes of the floor, degrees, uphill positive."""
    delays: Numbers = (0.01, 0.02)
    """Times by which instruments of torso and soles are told late, s."""
    motor_strengths: Numbers = (0.8,)
    """Shares of their strength that motors have; of policies whose motors have one (`--actuators`)."""
    noises: Numbers = (0.0, 2.0, 4.0)
    """Scales of the sensors' noise."""
    speeds: Numbers = (0.7, 0.85, 1.15, 1.3)
    """Speeds that are asked for, m/s."""
    walkers: shared.Walkers = 64
    seconds: shared.MeasuredSeconds = 7.0
    impulses: Impulses = (-80.0, -60.0, -40.0, -20.0, 20.0, 40.0, 55.0, 70.0)
    """Pushes to try on the policy's own body, N s, with commas between; positive ones push forward."""
    phases: shared.Phases = 8
    replicas: shared.Replicas = 1
    engine: shared.Engine = "mjx"
    seed: shared.Seed = 0

    def check(self) -> None:
        """As `Options.check`."""
        checks.policy(self.policy)
        if self.beside != NOBODY:
            checks.policy(self.beside)
        for kind in self.only:
            if kind not in KINDS:
                raise UserError(f"--only {kind}: give some of {', '.join(KINDS)}")
        for value in self.statures:
            checks.between("--statures", value, 0.5, 3.0, " m")
        for value in self.masses:
            checks.between("--masses", value, 5.0, 500.0, " kg")
        for option, packs in (("--backpacks", self.backpacks), ("--front-packs", self.front_packs)):
            for value in packs:
                checks.between(option, value, 0.0, 100.0, " kg")
        for value in self.forces:
            checks.between("--forces", value, -500.0, 500.0, " N")
        for value in self.frictions:
            checks.between("--frictions", value, 0.01, 10.0, "")
        for value in self.slopes:
            checks.between("--slopes", value, -10.0, 10.0, " degrees")
        for value in self.delays:
            checks.between("--delays", value, 0.0, DELAY_MOST, " s")
        for value in self.motor_strengths:
            checks.between("--motor-strengths", value, 0.1, 1.0, "")
        for value in self.noises:
            checks.between("--noises", value, 0.0, 100.0, "")
        for value in self.speeds:
            checks.between("--speeds", value, 0.1, 3.0, " m/s")
        PushTest.of(self).check()
        files.check_folder("--out", self.out)

    def values(self) -> dict[str, tuple[float, ...]]:
        """What is tried of each kind."""
        return {
            kind: getattr(self, option.removeprefix("--").replace("-", "_"))
            for kind, option in KINDS.items()
            if kind in self.only or not self.only
        }


read = reader(GeneraliseArgs, "generalise")
