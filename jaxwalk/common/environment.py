"""What the environment may hold of libraries' settings, and the faults that come of it, as one line."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator

from jaxwalk.common.errors import UserError

NUMBERS = {
    "jax_enable_x64": False,
    "jax_default_prng_impl": "threefry2x32",
    "jax_threefry_partitionable": True,
    "jax_numpy_dtype_promotion": "standard",
    "jax_numpy_rank_promotion": "allow",
}
"""Settings of JAX that results rest on: a seed means one walk, in float32, whatever the environment holds."""
_PICTURES = {"MPLBACKEND": "agg", "MATPLOTLIBRC": os.devnull}  # drawn as everywhere
_STARTS = ("JAX_PLATFORMS", "JAX_NUM_CPU_DEVICES", "XLA_FLAGS", "CUDA_VISIBLE_DEVICES")
_LIBRARIES = ("JAX_", "XLA_", "MUJOCO_", "MPL", "MATPLOTLIB")


def settle() -> None:
    """Set what a command and its child processes compute and draw by. Before the libraries are imported."""
    os.environ.update(_PICTURES | {name.upper(): str(value).lower() for name, value in NUMBERS.items()})


@contextlib.contextmanager
def told(what: str) -> Iterator[None]:
    """Within it, a fault of a library's import that names a variable of the environment is one line.

    Raises:
      UserError: naming the variable, if a fault does.
    """
    try:
        yield
    except Exception as error:
        named = [name for name in os.environ if name.startswith(_LIBRARIES) and name.lower() in _low(error)]
        if not named:
            raise
        raise UserError(
            f"{named[0]}={os.environ[named[0]]}: {what} does not start with it{_reason(error)}; "
            "give another value, or leave it unset"
        ) from error


def start_devices() -> None:
    """Start JAX's devices, which whoever computes with it needs.

    Raises:
      UserError: the environment asks for some that there are not, or there are none.
    """
    import jax

    try:
        jax.devices()
    except Exception as error:  # each plugin has its own
        asked = " ".join(f"{name}={os.environ[name]}" for name in _STARTS if os.environ.get(name))
        raise UserError(
            f"JAX starts no devices here{asked and f' with {asked}'}{_reason(error)}; give "
            "JAX_PLATFORMS=cpu, or leave such variables unset"
        ) from error


def _low(error: Exception) -> str:
    return str(error).lower()


def _reason(error: Exception) -> str:
    lines = str(error).strip().splitlines()
    return f" ({lines[0]:.200})" if lines else ""
