"""``jaxwalk bench``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from jaxwalk import files
from jaxwalk.cli import checks
from jaxwalk.cli.parse import OptionalFile, OptionalPolicy, parse


@dataclass(frozen=True)
class BenchArgs:
    """Time bare mjx.step, the tick, the push map, training, its checkpoints; or a deployed policy."""

    walkers: int = 256
    """Walkers side by side, in all programs."""
    seconds: float = 10.0
    """How long each program is timed once compiled, s; with --deploy, each format."""
    seed: int = 0
    """Seed of everything that is drawn at random."""
    deploy: OptionalPolicy = None
    """Instead, time one decision and one tick of this policy, exported in every format: a run folder, a
    policy file or shipped."""
    json: OptionalFile = None
    """File for the results, replaced if there. Default: a table on the screen only."""

    def check(self) -> None:
        """Raises:
        UserError: an option out of its range.
        """
        checks.whole("--walkers", self.walkers)
        checks.positive("--seconds", self.seconds, "seconds")
        checks.seed(self.seed)
        if self.deploy is not None:
            checks.policy(self.deploy)
        if self.json is not None:
            files.check_output("--json", self.json)


def run(argv: Sequence[str]) -> None:
    args = parse(BenchArgs, argv, "bench")
    args.check()

    from jaxwalk import runtime

    runtime.setup()
    if args.deploy is not None:
        from jaxwalk.export import latency

        latency.main(args.deploy, args)
        return
    from jaxwalk.bench import command

    command.main(args)
