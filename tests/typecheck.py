"""The type checker of the tests: beartype on every call, but not on the making of dataclasses.

JAX rebuilds pytree dataclasses with whatever it maps over them (batches, specs, sentinels),
so a field's shape holds inside the functions on one walker, and is checked there.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from beartype import beartype

F = TypeVar("F", bound=Callable)


def check(function: F) -> F:
    return function if function.__name__ == "__init__" else beartype(function)
