"""``jaxwalk bench --stages`` and ``--batches``: where a tick goes, over batch sizes; tables and JSON."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.table import Table

from jaxwalk.common import figures, files
from jaxwalk.common.errors import UserError
from jaxwalk.common.parallel import devices
from jaxwalk.learn.policies import provenance
from jaxwalk.measure.bench import batches, picture
from jaxwalk.measure.bench.limits import C_CONVERGED, C_LIMITED
from jaxwalk.measure.bench.setting import configured, memory
from jaxwalk.measure.bench.stages import STAGES

if TYPE_CHECKING:
    from jaxwalk.measure.bench.options import BenchArgs


def bench(args: BenchArgs, report: Callable[[str], None] = lambda what: None) -> dict[str, Any]:
    """All of it, as the JSON that ``jaxwalk bench`` writes.

    Raises:
      UserError: a batch that the devices cannot share evenly.
    """
    sizes = args.sizes()
    count = devices.mesh().size
    for size in sizes:
        if args.batches and size % count:
            raise UserError(f"--batches {size}: give a multiple of the {count} devices")
    config = configured(sizes[0])
    names = tuple(STAGES) if args.stages else batches.SHORT
    rows = batches.measure(config, sizes, names, args.seconds, args.seed, report)
    return {
        "stages": {name: STAGES[name] for name in names},
        "batches": rows,
        "memory": memory(),
        **provenance.stamp("bench", args, None, config),
    }


def main(args: BenchArgs) -> None:
    """Run ``jaxwalk bench --stages`` or ``--batches``."""
    console = Console(markup=False)
    with console.status("starting") as status:
        result = bench(args, status.update)
    if args.json is not None:
        files.write_json(args.json, result)
        if (beside := args.picture()) is not None:
            figures.write_png(picture.draw(result), beside)
    show(console, result)


def show(console: Console, result: Mapping[str, Any]) -> None:
    """``result``, as `bench` gives it, on the screen: tables of time and of cost for each batch."""
    for row in result["batches"]:
        if "skipped" in row:
            console.print(f"{row['walkers']} walkers left out: {row['skipped']}", highlight=False)
        else:
            console.print(_times(row, on_cpu=picture.on_cpu(result)))
            console.print(_costs(row))
    hardware = ", ".join(dict.fromkeys(result["hardware"]["devices"]))
    console.print(
        f"{hardware}; {result['hardware']['cores']} cores; jax {result['versions']['jax']}, "
        f"mujoco-mjx {result['versions']['mujoco-mjx']}; "
        f"peak memory {result['memory']['peak_rss_mb']:,.0f} MB",
        highlight=False,
    )


def _empty(title: str, caption: str, headings: Sequence[str]) -> Table:
    table = Table(title=title, caption=caption)
    table.add_column("with all before it", no_wrap=True)
    for heading in headings:
        table.add_column(heading, justify="right")
    return table


def _times(row: Mapping[str, Any], on_cpu: bool) -> Table:
    """A table of time: ratios, and rates on a GPU; on a CPU, what a stage adds in processor time, too."""
    headings = ["of bare", "of C", "adds", "adds, CPU" if on_cpu else "ticks/s", "compile, s"]
    caption = "adds: share of training's time; * from the compilation cache"
    table = _empty(f"{row['walkers']} walkers, {row['ticks_per_call']} ticks a call", caption, headings)
    for name, one in row["programs"].items():
        processor, rate = f"{one['added_processor_share']:.1%}", f"{one['physics_steps_per_second']:,.0f}"
        table.add_row(
            name.replace("_", " "),
            f"{one['of_bare']:.2f}",
            f"{one['of_c_mujoco']:.2f}",
            f"{one['added_share']:.1%}",
            processor if on_cpu else rate,
            f"{one['compile_seconds']:.1f}{'*' if one['compile_cached'] else ' '}",
        )
    table.add_section()
    for name, what in ((C_LIMITED, "C, as many iterations"), (C_CONVERGED, "C, converged")):
        one = row["limits"][name]
        own = one["of_bare"] / row["limits"][C_LIMITED]["of_bare"]
        rate = [] if on_cpu else ["", f"{one['physics_steps_per_second']:,.0f}"]
        table.add_row(what, f"{one['of_bare']:.2f}", f"{own:.2f}", *rate)
    return table


def _costs(row: Mapping[str, Any]) -> Table:
    """A table of what each stage costs by XLA's analysis."""
    headings = ["kflop/tick", "kB/tick", "of peak flop/s", "of peak B/s", "MB"]
    table = _empty("", "by XLA's analysis; MB: arguments and scratch of one device", headings)
    for name, one in row["programs"].items():
        held = one["memory_bytes"]
        table.add_row(
            name.replace("_", " "),
            _told(one["flops_per_tick"], 1e-3, ",.1f"),
            _told(one["bytes_per_tick"], 1e-3, ",.1f"),
            _told(one["of_peak_flops"], 1.0, ".1%"),
            _told(one["of_peak_bytes"], 1.0, ".1%"),
            "-" if held is None else f"{(held['argument'] + held['temp']) / 1e6:,.1f}",
        )
    return table


def _told(value: float | None, unit: float, form: str) -> str:
    return "-" if value is None else f"{value * unit:{form}}"
