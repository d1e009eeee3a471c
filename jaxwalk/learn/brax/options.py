"""``jaxwalk train-baseline``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated

import tyro

from jaxwalk.common.errors import UserError
from jaxwalk.learn.runs import run_folder
from jaxwalk.options import checks, shared
from jaxwalk.options.parse import OptionalFile, checked


@dataclass(frozen=True)
class PPO:
    """Brax's PPO. A round is ``batch_size`` x ``minibatches`` unrolls: by default 1,280 footsteps."""

    walkers: int = 128
    """Walkers that learn side by side, a footstep at a time."""
    unroll_length: int = 10
    """Footsteps in a row of one walker (with gamma 0.8, what comes later hardly counts)."""
    batch_size: int = 32
    """Unrolls in one minibatch."""
    minibatches: int = 4
    """Minibatches of a round."""
    epochs: int = 8
    """How often a round's footsteps are gone through."""
    learning_rate: float = 3e-4
    """Learning rate of both networks (Schulman et al. 2017, table 3)."""
    clipping: float = 0.2
    """Clipping of the probability ratio (the same)."""
    gae_lambda: float = 0.95
    """Generalised advantage estimation (the same)."""
    entropy_cost: float = 1e-3
    """Weight of the entropy bonus."""
    first_std: float = 0.25
    """Standard deviation of the first policy, before tanh."""

    def check(self) -> None:
        """As `Options.check`."""
        for name in ("walkers", "unroll_length", "batch_size", "minibatches", "epochs"):
            checks.whole(f"--{name.replace('_', '-')}", getattr(self, name))
        if self.batch_size * self.minibatches % self.walkers:
            raise UserError(
                f"--walkers {self.walkers}: --batch-size times --minibatches, "
                f"{self.batch_size * self.minibatches}, must be a multiple of it"
            )
        checks.positive("--learning-rate", self.learning_rate, "1")
        checks.positive("--first-std", self.first_std, "1")
        checks.between("--clipping", self.clipping, 0.01, 1.0, "")
        checks.between("--gae-lambda", self.gae_lambda, 0.0, 1.0, "")
        checks.between("--entropy-cost", self.entropy_cost, 0.0, 10.0, "")


@dataclass(frozen=True)
class SAC:
    """Brax's SAC."""

    walkers: int = 128
    """Walkers that learn side by side, a footstep at a time."""
    updates_per_footstep: float = 1.0
    """Updates for each footstep gathered: with few footsteps, each is used often."""
    batch_size: int = 256
    """Transitions in one update (Haarnoja et al. 2018, table 1)."""
    learning_rate: float = 3e-4
    """Learning rate of all networks (the same)."""
    tau: float = 0.005
    """Share of the critics that enters their targets at each update (the same)."""
    warmup: int = 4_000
    """Footsteps gathered before the first update, as in jaxwalk train."""
    reward_scaling: float = 10.0
    """The reward's weight against the entropy, whose own weight begins at 1."""
    first_std: float = 0.25
    """Standard deviation of the first policy, before tanh."""

    def check(self) -> None:
        """As `Options.check`."""
        for name in ("walkers", "batch_size"):
            checks.whole(f"--{name.replace('_', '-')}", getattr(self, name))
        checks.whole("--warmup", self.warmup, least=0)
        for name in ("updates_per_footstep", "learning_rate", "reward_scaling", "first_std"):
            checks.positive(f"--{name.replace('_', '-')}", getattr(self, name), "1")
        checks.between("--tau", self.tau, 1e-6, 1.0, "")
        if round(self.walkers * self.updates_per_footstep) < 1:
            raise UserError(
                f"--updates-per-footstep {self.updates_per_footstep:g}: {self.walkers} walkers call for "
                f"{1 / self.walkers:g} or more, an update each time that all have taken a footstep"
            )


@dataclass(frozen=True)
class _Common:
    run_dir: OptionalFile = None
    """Folder for the results, new or without a run in it. Default: runs/<date>-<time>."""
    seed: shared.Seed = 0
    footsteps: int = 40_000
    """Footsteps gathered before training ends, rounded up to whole rounds."""
    evaluations: int = 16
    """Evaluations spread over training; the best ones' policies meet in the finals."""

    def _check(self) -> None:
        checks.seed(self.seed)
        checks.whole("--footsteps", self.footsteps)
        checks.whole("--evaluations", self.evaluations)
        if self.run_dir is not None:
            run_folder.check_free(self.run_dir)


@dataclass(frozen=True)
class PPOArgs(_Common):
    """Train a policy with PPO in Brax, on the default task, from the same first step as jaxwalk train."""

    settings: Annotated[PPO, tyro.conf.arg(name="")] = field(default_factory=PPO)

    def check(self) -> None:
        """See that the options can be meant.

        Raises:
          UserError: an option out of its range, or a run folder that cannot be used.
        """
        self._check()
        self.settings.check()


@dataclass(frozen=True)
class SACArgs(_Common):
    """Train a policy with SAC in Brax, on the default task, from the same first step as jaxwalk train."""

    settings: Annotated[SAC, tyro.conf.arg(name="")] = field(default_factory=SAC)

    def check(self) -> None:
        """See that the options can be meant.

        Raises:
          UserError: an option out of its range, or a run folder that cannot be used.
        """
        self._check()
        self.settings.check()
        walkers, warmup = self.settings.walkers, self.settings.warmup
        filled = -(-warmup // walkers) * walkers  # Brax gathers whole rounds
        if filled >= self.footsteps:
            raise UserError(
                f"--warmup {warmup}: {walkers} walkers gather {filled} footsteps for it, "
                f"which must be less than --footsteps, {self.footsteps}"
            )


ALGORITHMS = {"ppo": PPOArgs, "sac": SACArgs}


def read(argv: Sequence[str]) -> PPOArgs | SACArgs:
    """The options of the algorithm that is named first, checked.

    Raises:
      UserError: no such algorithm, or one of its options is wrong.
      SystemExit: code 0, after printing the help that was asked for.
    """
    name, *rest = argv or ("",)
    known = " or ".join(ALGORITHMS)
    if name in ("-h", "--help"):
        print(f"usage: jaxwalk train-baseline ALGORITHM [options]\nALGORITHM: {known}; see its own --help.")
        raise SystemExit(0)
    if name not in ALGORITHMS:
        raise UserError(f"no algorithm {name!r}: give {known}, as in jaxwalk train-baseline ppo --seed 1")
    return checked(ALGORITHMS[name], rest, f"train-baseline {name}")
