"""Ticks a second of the plant alone: bare ``mjx.step``, the package's own by XLA, by native code or kernels.

python scripts/plant_rates.py [--batches 4096,65536] [--ticks 100] [--rounds 3] [--json FILE]

All replay the same joint commands from the same walkers in mid-step, batch by batch in one process.
"""

from __future__ import annotations

import dataclasses
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import jax
import numpy as np
from rich.console import Console
from rich.table import Table

from jaxwalk.common import files, runtime
from jaxwalk.common.errors import UserError
from jaxwalk.common.parallel import devices
from jaxwalk.measure.bench import stages
from jaxwalk.measure.bench.programs import bare_steps, record, sharded, split, standing, unpushed, walk_ticks
from jaxwalk.measure.bench.setting import configured
from jaxwalk.options.parse import Numbers, OptionalFile, parse
from jaxwalk.task import backend
from jaxwalk.task.stepper import Task

WALKED = 256  # walkers that walk first; a batch is these over again
SETTLE_WINDOWS = 60


@dataclass(frozen=True)
class Args:
    """Ticks a second of the plant alone."""

    batches: Numbers = (4096, 65536)
    """Walkers."""
    ticks: int = 100
    """In a call."""
    rounds: int = 3
    """Calls of each program; the fastest counts."""
    json: OptionalFile = None
    """File for the results."""


def rate(
    args: Args, walkers: int, mesh: Any, function: Callable[..., Any], body: Any, commands: Any
) -> float:
    """Ticks a second of ``function``, one walker's."""
    index = np.resize(np.arange(WALKED), walkers)
    body, commands = split(jax.tree.map(lambda x: x[index], (body, commands)), mesh)
    program = sharded(function, mesh).lower(body, commands).compile()
    jax.block_until_ready(program(body, commands))
    seconds = []
    for _ in range(args.rounds):
        begun = time.perf_counter()
        jax.block_until_ready(program(body, commands))
        seconds.append(time.perf_counter() - begun)
    return walkers * args.ticks / min(seconds)


def measure(args: Args) -> list[dict[str, float]]:
    """A row for each batch."""
    config = configured(WALKED)
    task, mesh = Task.of(config), devices.mesh(WALKED)
    fresh = sharded(partial(unpushed, config, task), mesh)(
        split(jax.random.split(jax.random.key(0), WALKED), mesh)
    )
    walked = standing(sharded(partial(walk_ticks, task, SETTLE_WINDOWS), mesh)(fresh)[0])
    commands = sharded(partial(record, task, args.ticks), mesh)(split(walked, mesh))
    plain = Task.of(dataclasses.replace(config, kernels="off"))
    rows = []
    for walkers in map(int, args.batches):
        run = partial(rate, args, walkers, devices.mesh(walkers))
        row = {
            "walkers": walkers,
            "mjx_step": run(partial(bare_steps, config, task), walked.walker, commands),
            "xla": run(partial(stages.plant_steps, plain), walked.walker, commands),
        }
        if backend.stepper_of(config) != "XLA":
            row["kernels"] = run(partial(stages.plant_steps, task), walked.walker, commands)
        rows.append(row)
    return rows


def main(argv: list[str]) -> int:
    try:
        args = parse(Args, argv, "plant_rates")
        if args.json is not None:
            files.check_output("--json", args.json)
    except UserError as error:
        print(f"plant_rates: error: {error}", file=sys.stderr)
        return 2
    runtime.setup()
    rows = measure(args)
    table = Table(*rows[0], title="ticks/s")
    for row in rows:
        table.add_row(*(f"{value:,.0f}" for value in row.values()))
    Console().print(table)
    if args.json is not None:
        result = {"plant": [{"ticks_per_second": row} for row in rows], "ticks_per_call": args.ticks}
        files.write_json(Path(args.json), result | runtime.hardware())
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
