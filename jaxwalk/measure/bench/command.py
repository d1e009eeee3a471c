"""``jaxwalk bench``: the table and its JSON."""

from __future__ import annotations

import statistics
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.table import Table

from jaxwalk.common import files
from jaxwalk.learn.policies import provenance
from jaxwalk.measure.bench import batches, deploy_latency, scaling
from jaxwalk.measure.bench.rounds import BARE, BY_XLA, LOOP, MAP, SAVING, TICK, Program
from jaxwalk.measure.bench.setting import configured, memory

if TYPE_CHECKING:
    from jaxwalk.measure.bench.options import BenchArgs


def bench(args: BenchArgs, report: Callable[[str], None] = lambda what: None) -> dict[str, Any]:
    """All of it, as the JSON that ``jaxwalk bench`` writes."""
    config = configured(args.walkers)
    with tempfile.TemporaryDirectory() as folder:
        programs = batches.whole(config, args.seconds, args.seed, Path(folder), report)
    ticks = config.train.windows_per_report * config.train.window_ticks
    result: dict[str, Any] = {"programs": {}}
    for name, program in programs.items():
        steps = [float(args.walkers * ticks)] * len(program.seconds)
        learns = name in (LOOP, SAVING)
        result["programs"][name] = {
            "physics_steps_per_second": program.rate(steps),
            "footsteps_per_second": None if name == BARE else program.rate(program.footsteps),
            "updates_per_second": program.rate(program.updates) if learns else None,
            "compile_seconds": program.compile_seconds,
            "compile_cached": program.cached,
            "round_seconds": program.seconds,
        }
    rates = {name: row["physics_steps_per_second"] for name, row in result["programs"].items()}
    return result | {
        "ratios": {f"{name}/{BARE}": rates[name] / rates[BARE] for name in (BY_XLA, TICK, MAP, LOOP)},
        "checkpoint": _checkpoint(programs, config.train.checkpoint_seconds),
        "walkers": args.walkers,
        "ticks_per_call": ticks,
        "memory": memory(),
        **provenance.stamp("bench", args, None, config),
    }


def _checkpoint(programs: dict[str, Program], every: float) -> dict[str, float]:
    """What a checkpoint costs: s a round longer; and its share of training, one every ``every`` s."""
    pairs = zip(programs[SAVING].seconds, programs[LOOP].seconds, strict=True)
    cost = statistics.median(saving - alone for saving, alone in pairs)
    return {"seconds": cost, "every_seconds": every, "share": cost / every}


def main(args: BenchArgs) -> None:
    """Run ``jaxwalk bench``, or what its options ask for instead."""
    if args.deploy is not None:
        deploy_latency.main(args.deploy, args)
        return
    if args.stages or args.batches:
        scaling.main(args)
        return
    console = Console(markup=False)
    with console.status("starting") as status:
        result = bench(args, status.update)
    if args.json is not None:
        files.write_json(args.json, result)
    show(console, result)


def show(console: Console, result: dict[str, Any]) -> None:
    """``result``, as `bench` gives it, on the screen."""
    hardware = ", ".join(result["hardware"]["devices"])
    table = Table(title=f"{result['walkers']} walkers, {hardware}", caption="* from the compilation cache")
    table.add_column("program", no_wrap=True)
    for heading in ("ticks/s", "of bare", "footsteps/s", "updates/s", "compile, s"):
        table.add_column(heading, justify="right")
    for name, row in result["programs"].items():
        ratio = 1.0 if name == BARE else result["ratios"].get(f"{name}/{BARE}")
        rates = [row[f"{what}_per_second"] for what in ("footsteps", "updates")]
        told = ["-" if rate is None else f"{rate:,.0f}" for rate in rates]
        compiled = f"{row['compile_seconds']:.1f}{'*' if row['compile_cached'] else ' '}"
        table.add_row(
            name,
            f"{row['physics_steps_per_second']:,.0f}",
            "-" if ratio is None else f"{ratio:.2f}",
            *told,
            compiled,
        )
    console.print(table)
    saved = result["checkpoint"]
    console.print(
        f"a checkpoint costs {saved['seconds']:.2f} s, {saved['share']:.1%} of training "
        f"(one every {saved['every_seconds']:.0f} s)",
        highlight=False,
    )
    console.print(f"peak memory {result['memory']['peak_rss_mb']:,.0f} MB", highlight=False)
