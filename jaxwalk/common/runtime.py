"""Settings of JAX for this process, and what it runs on. Commands call ``setup`` first."""

from __future__ import annotations

import contextlib
import importlib
import io
import os
import platform
import resource
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from jaxwalk import __version__
from jaxwalk.common import compile_cache, environment

_CGROUPS = Path("/sys/fs/cgroup")
_CGROUP = _CGROUPS / "cpu.max"
_MEMORY = (  # of version 2 and 1
    ("memory.max", "memory.current"),
    ("memory/memory.limit_in_bytes", "memory/memory.usage_in_bytes"),
)
_REPORTED = ("jax", "jaxlib", "mujoco", "mujoco-mjx", "brax", "flax", "optax", "numpy")


def setup(begun: bool = False) -> None:
    """Use all cores, remember compiled programs, keep quiet. To be called before JAX computes.

    Args:
      begun: the process is not a command's: JAX may compute already, and what its owner has set stands;
        `as_ours` is for what results rest on.

    What the user has chosen through JAX's own environment variables or ``XLA_FLAGS`` stands, but for what
    results rest on (`environment.NUMBERS`).

    Raises:
      UserError: the environment holds what JAX or MuJoCo does not start with.
      RuntimeError: JAX already computes with another number of CPU devices.
    """
    if not begun:
        environment.settle()
    with environment.told("JAX"):
        import jax

    kept = compile_cache.folder()
    settings = {
        # JAX skips programs that compile within a second; a test suite has hundreds of those.
        "jax_persistent_cache_min_compile_time_secs": 0.0,
        "jax_persistent_cache_min_entry_size_bytes": -1,
    }
    if kept:
        settings["jax_compilation_cache_dir"] = kept
        compile_cache.guard(kept)
    # XLA runs an MJX program on one core per device: several devices are how all cores are used.
    if "xla_force_host_platform_device_count" not in os.environ.get("XLA_FLAGS", ""):
        settings["jax_num_cpu_devices"] = _cores()
    for name, value in settings.items():
        if name.upper() not in os.environ:
            with contextlib.suppress(RuntimeError) if begun else contextlib.nullcontext():
                jax.config.update(name, value)
    if not begun:
        for name, value in environment.NUMBERS.items():
            jax.config.update(name, value)
    with environment.told("MuJoCo"):
        _import_mjx_quietly()


@contextlib.contextmanager
def in_float32() -> Iterator[None]:
    """Within it, in this thread, JAX computes in commands' types, whatever the process has set."""
    import jax

    with jax.enable_x64(False), jax.numpy_dtype_promotion("standard"), jax.numpy_rank_promotion("allow"):
        yield


@contextlib.contextmanager
def as_ours() -> Iterator[None]:
    """As `in_float32`, and with the random numbers that commands have."""
    import jax

    with in_float32(), jax.default_prng_impl("threefry2x32"), jax.threefry_partitionable(True):
        yield


def has_accelerator() -> bool:
    """Whether JAX finds one here; without a plugin for accelerators it is not asked.

    It is asked in a process of its own: this one may have to join others before it starts its devices.
    """
    from importlib import metadata

    if not metadata.entry_points(group="jax_plugins"):
        return False
    asked = subprocess.run(
        [sys.executable, "-c", "import jax; print(jax.default_backend())"],
        env=os.environ | {"XLA_PYTHON_CLIENT_PREALLOCATE": "false"},
        capture_output=True,
        text=True,
    )
    return asked.returncode == 0 and asked.stdout.strip() != "cpu"


def hardware() -> dict[str, Any]:
    """What a measurement was made on: ``{"hardware": {...}, "versions": {...}}``, as JSON values.

    Starts JAX's devices.
    """
    import jax

    pages, page = os.sysconf("SC_PHYS_PAGES"), os.sysconf("SC_PAGE_SIZE")
    return {
        "hardware": {
            "cpu": _cpu_model(),
            "cores": _cores(),
            "memory_gb": round(pages * page / 1e9, 1),
            "devices": [f"{device.platform}: {device.device_kind}" for device in jax.devices()],
            "system": platform.platform(),
        },
        **versions(),
    }


def versions() -> dict[str, dict[str, str]]:
    """What a result was computed with: ``{"versions": {...}}``."""
    from importlib import metadata  # slow enough to be felt in --help

    return {
        "versions": {
            "jaxwalk": __version__,
            "python": platform.python_version(),
            **{name: metadata.version(name) for name in _REPORTED},
        }
    }


def memory_left() -> int:
    """Bytes that this process can still take: of the machine, of its container, of its own limit."""
    left = [sys.maxsize]
    with contextlib.suppress(OSError, ValueError, StopIteration):
        lines = Path("/proc/meminfo").read_text().splitlines()
        left.append(1024 * int(next(line for line in lines if line.startswith("MemAvailable:")).split()[1]))
    most, _ = resource.getrlimit(resource.RLIMIT_AS)
    with contextlib.suppress(OSError, ValueError):
        taken = int(Path("/proc/self/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
        left += [max(0, most - taken)] if most != resource.RLIM_INFINITY else []
    for limit, use in _MEMORY:
        with contextlib.suppress(OSError, ValueError):  # "max" is no number
            left.append(max(0, int((_CGROUPS / limit).read_text()) - int((_CGROUPS / use).read_text())))
    return min(left)


def _cores() -> int:
    """Cores that this process may use; a container's share can be less than the machine's."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(cores, _quota(_CGROUP) or cores)


def _quota(file: Path) -> int | None:
    """Whole cores that a Linux control group grants (``cpu.max``: quota and period, us); None: no limit."""
    with contextlib.suppress(OSError, ValueError):
        quota, period = file.read_text().split()
        return max(1, int(quota) // int(period))  # "max" is no number
    return None


def _cpu_model() -> str:
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def _import_mjx_quietly() -> None:
    """``import mujoco.mjx`` less the two lines that it prints about Warp, which is not used here."""
    if "mujoco.mjx" in sys.modules:
        return
    output = io.StringIO()
    with contextlib.redirect_stdout(output):
        importlib.import_module("mujoco.mjx")
    for line in output.getvalue().splitlines():
        if not line.startswith(("Failed to import warp:", "Failed to import mujoco_warp:")):
            print(line)
