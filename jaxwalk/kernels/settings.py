"""JAX's settings, as the calling thread has them."""

from __future__ import annotations

from typing import Any

import jax


def jax_setting(name: str) -> Any:
    """A setting's value; `jax.config` makes its attributes as it runs, and tells no type checker of them."""
    return getattr(jax.config, name)
