"""Let pushed walkers walk for a thousand million ticks, and look whether anything in them goes wrong.

    python scripts/endurance.py --out docs/results/endurance.json

They explore and are remembered as in a training that never learns: what is asked is whether the replay holds
a number that is not finite, how many walkers had to be started anew, and whether memory grows.
"""

from __future__ import annotations

import resource
import time
from dataclasses import dataclass
from pathlib import Path

import jax
import numpy as np
import tyro

from jaxwalk.common import files, runtime
from jaxwalk.common.parallel import devices
from jaxwalk.config.presets import PRESETS
from jaxwalk.learn.policies import provenance
from jaxwalk.learn.train import device_loop


@dataclass(frozen=True)
class Args:
    """Walk for very long."""

    millions: float = 1000.0
    """Ticks of all walkers together, in millions."""
    seed: int = 0
    """Of starts, pushes, noise and exploration."""
    out: Path = Path("endurance.json")
    """Where what came of it goes (JSON)."""


def main(args: Args) -> None:
    """Walk; write what came of it."""
    config, mesh = PRESETS["default"], devices.mesh()
    loop = device_loop.make(config, mesh, learns=False)
    state = device_loop.init(config, mesh, args.seed)
    ticks = config.train.walkers * config.train.window_ticks * config.train.windows_per_report
    reports = max(1, round(args.millions * 1e6 / ticks))
    sums = {"falls": 0, "truncations": 0, "broken": 0}
    memory, begun = [], time.monotonic()
    for report in range(reports):
        state = loop(state)
        for name in sums:
            sums[name] += int(getattr(state.counts, name))
        if report % max(1, reports // 10) == 0 or report == reports - 1:
            memory.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024)
            told = f"{(report + 1) * ticks / 1e6:.0f} million ticks, {sums}, {memory[-1]} MiB"
            print(f"{time.monotonic() - begun:.0f} s  {told}", flush=True)
    kept = [np.asarray(x) for x in jax.tree.leaves(jax.device_get(state.replay))]
    finite = all(np.isfinite(x).all() for x in kept if np.issubdtype(x.dtype, np.floating))
    found = {
        "ticks": reports * ticks,
        "seconds": time.monotonic() - begun,
        "replay_finite": finite,
        "most_memory_mib": memory,
        **sums,
    }
    stamp = provenance.stamp("scripts/endurance.py", args, None, config)
    files.write_json(args.out, stamp | found)
    print(found)


if __name__ == "__main__":
    runtime.setup()
    main(tyro.cli(Args, description=__doc__))
