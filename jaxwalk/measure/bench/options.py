"""``jaxwalk bench``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from jaxwalk.common import files
from jaxwalk.common.errors import UserError
from jaxwalk.options import checks, shared
from jaxwalk.options.parse import Numbers, OptionalFile, OptionalPolicy, plain, reader


@dataclass(frozen=True)
class BenchArgs:
    """Time bare mjx.step, the tick, the push map, training, its checkpoints; or what a tick is made of, over
    batch sizes; or a deployed policy."""

    walkers: int = 256
    """Walkers side by side, in all programs."""
    seconds: float = 10.0
    """How long each program is timed once compiled, s; with --deploy, each format."""
    stages: bool = False
    """Instead, time bare mjx.step and what training adds to it, one stage after another, with C MuJoCo and
    the machine's peaks beside them."""
    batches: Numbers = ()
    """Instead, time bare mjx.step, the tick and training (with --stages: each stage) in batches of these
    sizes; beside --json a picture of the same name."""
    seed: shared.Seed = 0
    deploy: OptionalPolicy = None
    """Instead, time one decision and one tick of this policy, exported in every format: a run folder, a
    policy file or shipped."""
    json: OptionalFile = None
    """File for the results, replaced if there. Default: a table on the screen only."""

    def check(self) -> None:
        """As `Options.check`."""
        checks.walkers("--walkers", self.walkers)
        checks.positive("--seconds", self.seconds, "seconds")
        checks.seed(self.seed)
        self._check_batches()
        if self.deploy is not None:
            checks.policy(self.deploy)
        if self.json is not None:
            files.check_output("--json", self.json)
            if (beside := self.picture()) is not None:
                if beside == self.json:
                    raise UserError(f"--json {self.json}: the picture gets that name; give one with .json")
                files.check_output("--json", beside)

    def _check_batches(self) -> None:
        if self.deploy is not None and (self.stages or self.batches):
            raise UserError(
                "--deploy: times a policy outside of training; leave --stages and --batches out with it"
            )
        if not self.batches:
            return
        shown = ",".join(map(plain, self.batches))
        if any(value != int(value) for value in self.batches):
            raise UserError(f"--batches {shown}: give whole numbers")
        for value in self.batches:
            checks.walkers("--batches", int(value))
        checks.ascending("--batches", self.batches)
        if self.walkers != type(self).walkers:
            raise UserError(f"--walkers {self.walkers}: --batches tells how many; leave one of the two out")

    def sizes(self) -> tuple[int, ...]:
        """Walkers of each batch."""
        return tuple(map(int, self.batches)) or (self.walkers,)

    def picture(self) -> Path | None:
        """The picture of batches beside ``json``, if that is a file that something can lie beside."""
        if not self.batches or self.json is None or files.is_stream(self.json):
            return None
        return self.json.with_suffix(".png")


read = reader(BenchArgs, "bench")
