"""The commands that a report is made of: where their results lie, and how large their samples are."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from jaxwalk.measure.agreement.options import AgreementArgs
from jaxwalk.measure.bench.options import BenchArgs
from jaxwalk.measure.compare.options import CompareArgs
from jaxwalk.measure.evaluate.options import EvaluateArgs
from jaxwalk.measure.gait.options import GaitArgs
from jaxwalk.measure.generalise.options import GeneraliseArgs
from jaxwalk.measure.push_map.options import PushMapArgs
from jaxwalk.measure.report.options import Name
from jaxwalk.measure.sensitivity.options import SensitivityArgs
from jaxwalk.options import checks

_IMPULSES = (-100.0, -80.0, -60.0, -50.0, -40.0, -30.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0)
_FEW: dict[str, Any] = {"impulses": (-80.0, -60.0, -40.0, 40.0, 60.0, 80.0), "phases": 4, "replicas": 1}
_SAMPLE = ("walkers", "seconds", "phases", "replicas")  # the more, the surer


@dataclass(frozen=True)
class Part:
    """One command's results.

    Attributes:
      command: its name, and that of the folder of its results.
      title: on the page.
      kind: its options.
      json, png: names of its files; no picture: None.
      options: of a full measurement, where they depart from the command's defaults; quick: of a small one.
    """

    command: Name
    title: str
    kind: type
    json: str
    png: str | None
    options: Mapping[str, Any] = field(default_factory=dict)
    quick: Mapping[str, Any] = field(default_factory=dict)

    @property
    def module(self) -> str:
        """The module whose ``main`` runs the command: ``command``, beside its ``options``."""
        return self.kind.__module__.removesuffix("options") + "command"

    def place(self, folder: Path) -> dict[str, Path]:
        """The option that says where results go, for results under ``folder``."""
        home = folder / self.command
        return {"json": home / self.json} if self.png is None else {"out": home}

    def args(self, policy: str, folder: Path, quick: bool, seed: int) -> Any:
        """The options to measure ``policy`` with."""
        changed = {**self.options, **(self.quick if quick else {}), **self.place(folder), "seed": seed}
        names = {one.name for one in dataclasses.fields(self.kind)}
        if "policies" in names:
            baselines = [name for name in checks.BUILT_IN if name not in (*checks.TRAINED, policy)]
            changed["policies"] = (*baselines, policy)
        elif "policy" in names:
            changed["policy"] = policy
        return self.kind(**changed)

    def small(self, args: Any) -> bool:
        """Whether ``args`` measure fewer walkers, or shorter, than a full measurement does."""
        if self.command == "bench":
            return False  # of the machine, not of walkers
        full = self.args("", Path(), False, 0)
        # As many replicas as the machine makes light of are nobody's measure.
        told = [name for name in _SAMPLE if getattr(full, name, None) is not None]
        return any(getattr(args, name) < getattr(full, name) for name in told)


PARTS: dict[Name, Part] = {
    part.command: part
    for part in (
        Part(
            "compare", "Beside the baselines", CompareArgs,
            "compare.json", "compare.png", {"impulses": _IMPULSES},
            {"walkers": 16, "seconds": 8.0, **_FEW},
        ),
        Part(
            "evaluate", "Walking, and pushes one by one", EvaluateArgs,
            "evaluate.json", None, {"impulses": _IMPULSES},
            {"walkers": 32, "seconds": 8.0, **_FEW},
        ),
        Part(
            "push-map", "Push map", PushMapArgs,
            "map.json", "map.png", {}, {**_FEW, "phases": 8},
        ),
        Part(
            "generalise", "Bodies, loads, floors, sensors and speeds",
            GeneraliseArgs, "generalise.json", "generalise.png", {}, {"walkers": 16, **_FEW},
        ),
        Part(
            "sensitivity", "What the results owe to the physics' settings",
            SensitivityArgs, "sensitivity.json", "sensitivity.png", {},
            {
                "timesteps": (0.001,), "iterations": (8.0,), "contact_timeconsts": (0.01,),
                "frictions": (0.7,), "walkers": 16, "seconds": 8.0, **_FEW,
            },
        ),
        Part(
            "agreement", "MJX beside C MuJoCo", AgreementArgs,
            "agreement.json", "agreement.png", {},
            {"walkers": 16, "seconds": 8.0, **_FEW},
        ),
        Part(
            "gait", "Gait", GaitArgs,
            "gait.json", "gait.png", {}, {"walkers": 8, "seconds": 10.0},
        ),
        Part(
            "bench", "Speed of the simulation", BenchArgs,
            "bench.json", None, {}, {"seconds": 2.0},
        ),
    )
}  # fmt: skip
"""By command, in the order of the page."""
