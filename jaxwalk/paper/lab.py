"""Where the claims are measured: the subjects, and each kind of measurement with its compiled program.

Programs are made once for all claims. Everything walks in batches, all of one size.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from jaxwalk.config import BodyModel, GaitConfig
from jaxwalk.learn.policies import named
from jaxwalk.learn.policies.named import Subject
from jaxwalk.learn.train.evaluation import IMPULSES
from jaxwalk.measure.evaluate import evaluation
from jaxwalk.measure.evaluate.evaluation import AFTER_PUSH, BEFORE_PUSH, Programs
from jaxwalk.measure.protocol import PushTest
from jaxwalk.model import push_points
from jaxwalk.model.burdens import Burden
from jaxwalk.paper import trace, trainings
from jaxwalk.paper.verdict import Interval, mean_of, share
from jaxwalk.task import scenarios
from jaxwalk.task.scenarios import Scenario
from jaxwalk.task.trials import Profile, Trial, survived

BATCH = 64
EXAM_SECONDS = 9.0  # the push comes in the sixth footstep, after some 3 s


@dataclass(frozen=True)
class Sample:
    """How much is measured on one body.

    Attributes:
      walkers: unpushed. seconds: that they walk.
      phases: of the step at which pushes begin. replicas: walkers for each push and phase.
    """

    walkers: int
    seconds: float
    phases: int
    replicas: int


_SAMPLES: dict[tuple[bool, BodyModel], Sample] = {
    (False, "planar"): Sample(64, 15.0, 16, 2),
    (False, "walls"): Sample(48, 10.0, 8, 1),
    (True, "planar"): Sample(24, 7.0, 8, 1),
    (True, "walls"): Sample(16, 6.0, 8, 1),
}


class Lab:
    """One session of measurements.

    Args:
      policy: whom the claims are put to. trained: folder of `trainings`.
      quick: small samples. seed: of starts and noise.
      progress: called with what is under way and the share of it that is done.
    """

    def __init__(
        self,
        policy: str,
        trained: Path,
        quick: bool,
        seed: int,
        progress: Callable[[str, float], None] = lambda what, share: None,
    ) -> None:
        self.policy, self.trained, self.quick, self.seed, self.progress = (
            policy,
            trained,
            quick,
            seed,
            progress,
        )
        self._programs = Programs(PushTest(walkers=BATCH, impulses=()))
        self._traces: dict[Any, trace.Trace] = {}
        self._recorders: dict[Any, trace.Recorder] = {}
        self._shares: dict[str, dict[str, Interval]] = {}

    def sample(self, model: BodyModel) -> Sample:
        """How much is measured on that body."""
        return _SAMPLES[self.quick, model]

    def subject(self, model: BodyModel) -> Subject:
        """Who walks on that body: the policy asked for; between walls the one trained there, if any."""
        own = trainings.policy_file(self.trained, "walls", 0)
        if model == "walls" and own.is_file():
            return named.load(str(own))
        return named.load(self.policy, model=model)

    def timestep(self, model: BodyModel) -> float:
        """Length of one tick on that body, s."""
        return self.subject(model).config.physics.timestep

    def fixed(self, model: BodyModel) -> Subject:
        """The step that is never adapted, on that body."""
        return named.load(named.FIXED, model=model)

    def trial(
        self,
        subject: Subject,
        scenario: Scenario,
        seconds: float,
        profile: Profile | None = None,
        numbers: GaitConfig | None = None,
        what: str = "trials",
    ) -> Trial:
        """Scenarios [N] run for ``seconds``.

        Args:
          profile: what recovery is held against; None: it is not asked for.
          numbers: of the controllers, if not the subject's own.
        """
        runner = self._programs.of(subject)
        numbers = subject.config.gait if numbers is None else numbers
        profile = Profile.blank() if profile is None else profile
        return runner.run(subject.params, numbers, profile, scenario, seconds, partial(self.progress, what))

    def scenarios(
        self,
        subject: Subject,
        impulse: np.ndarray,
        phase: np.ndarray,
        purpose: int = scenarios.PUSHED,
        point: Sequence[str] | None = None,
        burden: Burden | None = None,
    ) -> Scenario:
        """[N] scenarios of the configured body; ``point``: where pushes land, default the torso's centre."""
        count = len(impulse)
        places = [push_points.Point.of(name) for name in point or ["torso"] * count]
        return scenarios.batch(
            subject.config,
            np.asarray(impulse, np.float32),
            np.asarray(phase, np.float32),
            scenarios.keys(self.seed, purpose, count),
            np.array([place.height for place in places]),
            push_place=np.array([push_points.PLACES.index(place.place) for place in places]),
            burden=burden,
        )

    def profile(self, subject: Subject, model: BodyModel) -> Profile:
        """The unpushed walk of ``subject``, which recovery is held against."""
        none = np.zeros(self.sample(model).walkers)
        calm = self.scenarios(subject, none, none, scenarios.CALM)
        return evaluation.profile_of(self.trial(subject, calm, self.sample(model).seconds, what="walking"))

    def pushed(self, subject: Subject, scenario: Scenario, profile: Profile | None) -> dict[str, np.ndarray]:
        """[N] of each push: whether the walker is up long after, and after how many s it was steady again."""
        trials = self.trial(subject, scenario, BEFORE_PUSH + AFTER_PUSH, profile, what="pushes")
        return {"up": survived(trials), "recovery": np.asarray(trials.tally.recovery)}

    def exam(
        self,
        subject: Subject,
        model: BodyModel,
        numbers: GaitConfig | None = None,
        what: str = "exam",
    ) -> dict[str, Any]:
        """Unpushed and pushed walking at once, as training's own evaluations.

        Returns:
          calm, pushed: shares that stay up (`Interval`). speed: of the unpushed, m/s (`Interval`).
          speeds: [C] of each unpushed walker that stayed up. survived: [P] of each push. impulses: [P] N s.
        """
        sample = self.sample(model)
        grid = [
            (i, p / sample.phases) for i in IMPULSES["rigid"] for p in range(sample.phases)
        ] * sample.replicas
        calm = -len(grid) % BATCH or BATCH  # the batch is filled up with the unpushed
        impulse, phase = np.array(grid + [(0.0, 0.0)] * calm).T
        trials = self.trial(
            subject, self.scenarios(subject, impulse, phase, scenarios.ASSESS), EXAM_SECONDS,
            numbers=numbers, what=what,
        )  # fmt: skip
        up, unpushed = survived(trials), impulse == 0
        speeds = speeds_of(trials, unpushed)
        return {
            "calm": share(up[unpushed]),
            "pushed": share(up[~unpushed]),
            "speed": mean_of(speeds),
            "speeds": speeds.tolist(),
            "survived": up[~unpushed].tolist(),
            "impulses": impulse[~unpushed].tolist(),
        }

    def shares(self, policy: str, what: str) -> dict[str, Interval]:
        """What the exam finds of a policy in the plane; several claims ask for the same ones.

        Returns:
          calm, pushed, speed: as `exam`.
        """
        if policy not in self._shares:
            found = self.exam(named.load(policy), "planar", what=what)
            self._shares[policy] = {name: found[name] for name in ("calm", "pushed", "speed")}
        return self._shares[policy]

    def trace(self, model: BodyModel, impulse: float = 0.0) -> trace.Trace:
        """Walkers tick by tick from the settled gait on; with a push of ``impulse`` N s, around it."""
        key = model, impulse
        if key not in self._traces:
            subject, sample = self.subject(model), self.sample(model)
            if model not in self._recorders:
                self._recorders[model] = trace.Recorder(subject, BATCH)
            walkers = min(sample.walkers, BATCH)
            self._traces[key] = self._recorders[model].record(
                subject.params, self.seed, walkers, sample.seconds, impulse, partial(self.progress, "traces")
            )
        return self._traces[key]


def speeds_of(trials: Trial, which: np.ndarray | slice) -> np.ndarray:
    """Mean speed of each walker among ``which`` that stayed up, m/s."""
    seconds, distance = (np.asarray(x)[which] for x in (trials.tally.seconds, trials.tally.distance))
    walked = survived(trials)[which] & (seconds > 1.0)
    return distance[walked] / seconds[walked]


def changed(numbers: GaitConfig, **values: Any) -> GaitConfig:
    """The controllers' numbers with others in some places, as floats that need no new program."""
    return dataclasses.replace(numbers, **{name: float(value) for name, value in values.items()})


def missing(lab: Lab, names: Sequence[str]) -> list[str]:
    """Files of trainings that are not there."""
    return [file for name in names for file in trainings.missing(lab.trained, name)]


def examined(lab: Lab, names: Sequence[str]) -> dict[str, Any]:
    """The exam and the curve of each training's policies, and of the step that is never adapted.

    Returns:
      missing: files that are not there; if any, nothing else. runs: by training, one entry each seed. fixed.
    """
    if absent := missing(lab, names):
        return {"missing": absent}
    runs: dict[str, list[dict[str, Any]]] = {}
    for name in names:
        runs[name] = []
        for seed in trainings.TRAININGS[name].seeds:
            told = trainings.curve(lab.trained, name, seed)
            shares = lab.shares(str(trainings.policy_file(lab.trained, name, seed)), name)
            runs[name].append({"seed": seed, "curve": dataclasses.asdict(told), **shares})
    return {"missing": [], "runs": runs, "fixed": lab.shares(named.FIXED, named.FIXED)}
