"""``jaxwalk train``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated, Literal

import tyro

from jaxwalk.common.errors import UserError
from jaxwalk.common.parallel.launch import Place
from jaxwalk.config import Config, validate
from jaxwalk.config.presets import PRESETS, PresetName, of_machine
from jaxwalk.learn.runs import run_folder, seeds_folder
from jaxwalk.options import checks, shared
from jaxwalk.options.parse import OptionalFile, OptionalPreset, checked, parse_known


@dataclass(frozen=True)
class _Origin:
    preset: OptionalPreset = None
    resume: OptionalFile = None


@dataclass(frozen=True)
class TrainArgs:
    """Train a policy into a run folder. Ctrl-C ends early and keeps the best policy."""

    preset: PresetName = "default"
    """The defaults of all options below: what works best on a few cores or on one accelerator, a quick trial,
    or the paper's constants. Default: gpu where JAX finds an accelerator, else default."""
    run_dir: OptionalFile = None
    """Folder for the results, new or without a run in it. Default: runs/<date>-<time>."""
    resume: OptionalFile = None
    """Go on with the stopped run in this folder, whose seed and configuration hold."""
    seed: shared.Seed = 0
    learner: Literal["ddpg", "es"] = "ddpg"
    """What learns: DDPG (``--ddpg.*``), or an evolution strategy on the same reward (``--es.*``), which is a
    search and cannot be resumed."""
    seeds: int = 1
    """Independent trainings in one program, of the seeds from --seed on: a run folder for each."""
    distributed: bool = False
    """This is one of several processes, on one machine or many, that SLURM, Kubernetes or MPI has started, or
    that are told of each other by the next three."""
    coordinator: str | None = None
    """HOST:PORT at which the first process can be reached by the others (with --distributed)."""
    processes: int | None = None
    """How many processes there are (with --coordinator)."""
    process_id: int | None = None
    """Which of them this is, from 0 (with --coordinator)."""
    config: Annotated[Config, tyro.conf.arg(name="")] = field(default_factory=Config)

    def check(self) -> None:
        """See that the options can be meant.

        Raises:
          UserError: an option out of its range, or a run folder that cannot be used.
        """
        checks.seed(self.seed)
        checks.between("--seeds", self.seeds, 1, 1024, ", each a training of its own")
        checks.seed(self.seed + self.seeds - 1)
        validate.check(self.config)
        checks.walkers("--train.walkers", self.config.train.walkers)
        checks.between("--es.candidates", self.config.es.candidates, 4, 10_000, ", half of which are kept")
        self.place.check()
        if self.distributed and self.seeds > 1:
            raise UserError("--distributed: several processes train one seed; give --seeds without it")
        if self.learner == "es" and (self.seeds > 1 or self.distributed):
            raise UserError("--learner es: one seed in one process; leave --seeds and --distributed out")
        if self.place != Place() and not self.distributed:
            raise UserError("--coordinator, --processes, --process-id: give --distributed with them")
        if self.run_dir is not None:
            (run_folder if self.seeds == 1 else seeds_folder).check_free(self.run_dir)

    @property
    def place(self) -> Place:
        """Where this process finds the others, if there are any."""
        return Place(self.coordinator, self.processes, self.process_id)


def read(argv: Sequence[str]) -> TrainArgs:
    """The options, defaults taken from the run or the preset that is named among them.

    Raises:
      UserError: an option that is wrong, or that contradicts the run that is resumed.
    """
    origin = parse_known(_Origin, argv, "train")
    if origin.resume is None:
        preset = origin.preset or of_machine()
        return checked(TrainArgs, argv, "train", TrainArgs(preset=preset, config=PRESETS[preset]))
    held = seeds_folder.members(origin.resume) if seeds_folder.is_parent(origin.resume) else [origin.resume]
    config = run_folder.load_config(held[0])
    default = TrainArgs(seed=run_folder.load_origin(held[0]).seed, seeds=len(held), config=config)
    args = checked(TrainArgs, argv, "train", default)
    for name, given, of_run in (
        ("preset", origin.preset, None),
        ("learner", args.learner, default.learner),
        ("run_dir", args.run_dir, None),
        ("seed", args.seed, default.seed),
        ("seeds", args.seeds, default.seeds),
        *(
            (name, value, own[1])
            for (name, value), own in zip(validate.leaves(args.config), validate.leaves(config), strict=True)
        ),
    ):
        if given != of_run:
            raise UserError(
                f"--{name.replace('_', '-')} {given}: the run in {origin.resume} "
                + ("has all of that" if of_run is None else f"has {of_run}")
                + "; leave the option out with --resume"
            )
    return args
