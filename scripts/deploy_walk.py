"""The deployed controllers on the walker in C MuJoCo, beside the JAX controllers on the same plant.

NumPy's and C's close the loop of `jaxwalk.task.deployed`; JAX's walk in ``jaxwalk evaluate --engine
mujoco``. All walk undisturbed, then meet the same pushes at the same phases of the step.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from jaxwalk import deploy
from jaxwalk.common import files, runtime
from jaxwalk.config import Config
from jaxwalk.export import c_runtime, command
from jaxwalk.learn.policies import named
from jaxwalk.measure.evaluate.evaluation import evaluate
from jaxwalk.measure.protocol import PushTest
from jaxwalk.task import deployed


def walked(config: Config, controller: Any, args: argparse.Namespace) -> dict[str, Any]:
    """Survival and speed undisturbed, and survival by impulse."""
    calm = [deployed.walk(config, controller, args.seconds, seed) for seed in range(args.walkers)]
    survival = {}
    for impulse in args.impulses:
        phases = np.arange(args.phases) / args.phases
        delays = [args.step_seconds * phase for phase in phases for _ in range(args.replicas)]
        pushed = [
            deployed.walk(config, controller, 13.0, 1000 + seed, deployed.Shove(impulse, delay))
            for seed, delay in enumerate(delays)
        ]
        survival[f"{impulse:+g}"] = float(np.mean([not walk.fell for walk in pushed]))
    speeds = [walk.speed for walk in calm if not walk.fell]
    return {
        "never_fell": float(np.mean([not walk.fell for walk in calm])),
        "speed": float(np.mean(speeds)) if speeds else None,
        "survival": survival,
    }


def in_jax(args: argparse.Namespace) -> dict[str, Any]:
    """The same of the JAX controllers."""
    asked = PushTest(
        args.walkers, args.seconds, tuple(args.impulses), args.phases, args.replicas, engine="mujoco"
    )
    found = evaluate(named.load(args.policy), asked)
    survived = zip(args.impulses, found["pushes"]["survival"], strict=True)
    return {
        "never_fell": found["walking"]["survival"],
        "speed": found["walking"]["speed_mean"],
        "survival": {f"{impulse:+g}": float(np.mean(row)) for impulse, row in survived},
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--policy", default="shipped")
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--walkers", type=int, default=8)
    parser.add_argument("--impulses", type=float, nargs="*", default=[-60.0, 60.0, 80.0])
    parser.add_argument("--phases", type=int, default=4)
    parser.add_argument("--replicas", type=int, default=4)
    parser.add_argument("--step-seconds", type=float, default=0.446, help="that phases are shares of")
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    runtime.setup()
    trained, told = command.load(args.policy)
    config = named.configured(named.file(args.policy), trained)
    rows = {}
    with tempfile.TemporaryDirectory() as folder:
        written = command.write(trained, told, ("npz", "c"), Path(folder))
        library = c_runtime.build(written["c"], Path(folder))
        body = config.body.height, config.body.mass, config.gait.speed_desired
        for name, controller in (
            ("c", c_runtime.Controller(library, *body)),
            ("numpy", deploy.Controller.load(written["npz"])),
        ):
            rows[name] = walked(config, controller, args)
            print(name, json.dumps(rows[name]), flush=True)
    rows["jax"] = in_jax(args)
    print("jax", json.dumps(rows["jax"]))
    if args.json is not None:
        options = {name: value for name, value in vars(args).items() if name != "json"}
        files.write_json(args.json, {"options": options, "controllers": rows, **runtime.hardware()})


if __name__ == "__main__":
    main()
