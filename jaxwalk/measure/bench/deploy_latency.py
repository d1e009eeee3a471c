"""How long a deployed policy takes: one decision, one tick of the whole controller, and the file's size."""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import jax
import numpy as np
from rich.console import Console
from rich.table import Table

from jaxwalk import deploy
from jaxwalk.common import files
from jaxwalk.export import c_runtime, command, onnx, stablehlo
from jaxwalk.learn.policies import named, policy, provenance
from jaxwalk.task import deployed

if TYPE_CHECKING:
    from jaxwalk.measure.bench.options import BenchArgs

_CALLS = 200  # in a round
_MIN_ROUNDS = 3
_WALK_SECONDS = 4.0  # of sensors that ticks are told of

Round = Callable[[], float]
"""Seconds for one call, over many."""


def of_calls(call: Callable[[Any], Any], inputs: list[Any]) -> Round:
    """One call from Python on each of ``inputs``."""

    def once() -> float:
        begun = time.perf_counter()
        for one in inputs:
            call(one)
        return (time.perf_counter() - begun) / len(inputs)

    return once


def microseconds(once: Round, seconds: float) -> float:
    """Median of the rounds made within ``seconds`` s, after one that is not counted."""
    once()
    rounds, begun = [], time.perf_counter()
    while len(rounds) < _MIN_ROUNDS or time.perf_counter() - begun < seconds:
        rounds.append(once())
    return 1e6 * statistics.median(rounds)


def measure(name: str, args: BenchArgs, report: Callable[[str], None] = lambda what: None) -> dict[str, Any]:
    """All of it for the policy called ``name``, as the JSON that ``jaxwalk bench --deploy POLICY`` writes.

    Decisions are of one observation, alone; those from Python include the call from Python.
    """
    report("exporting")
    trained, told = command.load(name)
    config = named.configured(named.file(name), trained)
    seen = command.observations(trained, _CALLS)
    rows = [one[None] for one in seen]
    with tempfile.TemporaryDirectory() as folder:
        written = command.write(trained, told, tuple(command.WRITERS), Path(folder))
        library = c_runtime.build(written["c"], Path(folder))
        in_numpy = {kind: deploy.Controller.load(written[kind]) for kind in ("safetensors", "npz")}
        in_c = c_runtime.Controller(library, config.body.height, config.body.mass, config.gait.speed_desired)
        report("walking")
        walk = deployed.walk(config, in_numpy["npz"], _WALK_SECONDS, args.seed, keep=True)
        session = onnx.require("onnxruntime").InferenceSession(
            str(written["onnx"]), providers=["CPUExecutionProvider"]
        )
        program, act = jax.jit(stablehlo.load(written["stablehlo"]).call), jax.jit(policy.act)
        plain = policy.without_origin(trained)
        decisions: dict[str, Round] = {
            "jax": of_calls(lambda one: jax.block_until_ready(act(plain, one)), rows),
            "stablehlo": of_calls(lambda one: jax.block_until_ready(program(one)), rows),
            "onnx": of_calls(lambda one: session.run(["action"], {"observation": one}), rows),
            "safetensors": of_calls(in_numpy["safetensors"].policy.act, list(seen)),
            "npz": of_calls(in_numpy["npz"].policy.act, list(seen)),
            "c": lambda: c_runtime.time_act(library, np.tile(seen, (20, 1))),
        }
        ticks: dict[str, Round] = {
            kind: of_calls(runtime.tick, walk.said[1:]) for kind, runtime in in_numpy.items()
        }
        ticks["c"] = lambda: in_c.time_ticks(walk.said[1:])
        for runtime in (*in_numpy.values(), in_c):
            runtime.start(walk.said[0], 0)
        found = {}
        for kind, once in decisions.items():
            report(f"timing {kind}")
            found[kind] = {
                "decision_us": microseconds(once, args.seconds),
                "tick_us": microseconds(ticks[kind], args.seconds) if kind in ticks else None,
                "bytes": written[kind].stat().st_size if kind in written else None,
            }
    return {"formats": found, **provenance.stamp("bench-deploy", args, None, config)}


def main(name: str, args: BenchArgs) -> None:
    """Run ``jaxwalk bench --deploy POLICY`` for the policy called ``name``."""
    console = Console(markup=False)
    with console.status("starting") as status:
        result = measure(name, args, status.update)
    if args.json is not None:
        files.write_json(args.json, result)
    table = Table(title=f"{name}, one at a time, on {result['hardware']['cpu']}")
    table.add_column("format", no_wrap=True)
    for heading in ("decision, us", "tick, us", "bytes"):
        table.add_column(heading, justify="right")
    for kind, row in result["formats"].items():
        tick = "-" if row["tick_us"] is None else f"{row['tick_us']:,.2f}"
        size = "-" if row["bytes"] is None else f"{row['bytes']:,}"
        table.add_row(kind, f"{row['decision_us']:,.2f}", tick, size)
    console.print(table)
