"""What is timed here, and what it took."""

from __future__ import annotations

import dataclasses
import resource
import sys

import jax

from jaxwalk.config import Config
from jaxwalk.config.presets import PRESETS, of_machine


def configured(walkers: int) -> Config:
    """The configuration that is timed: training in a batch of ``walkers``."""
    preset = PRESETS[of_machine()]
    # Updates begin as soon as there is something to learn from; nothing else departs from `jaxwalk train`.
    return dataclasses.replace(
        preset,
        train=dataclasses.replace(preset.train, walkers=walkers),
        ddpg=dataclasses.replace(preset.ddpg, warmup=walkers),
    )


def memory() -> dict[str, float | None]:
    """Most memory held since the process began, MB; None where the devices do not tell (CPUs)."""
    unit = 1 if sys.platform == "darwin" else 1024  # bytes there, KiB elsewhere
    stats = [device.memory_stats() for device in jax.local_devices()]
    known = [s["peak_bytes_in_use"] for s in stats if s and "peak_bytes_in_use" in s]
    return {
        "peak_rss_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6,
        "peak_device_mb": sum(known) / 1e6 if known else None,
    }
