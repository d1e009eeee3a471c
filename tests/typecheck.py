"""The type checker of the tests: beartype on every call, but not on the making of dataclasses.

JAX rebuilds pytree dataclasses with whatever it maps over them (batches, specs, sentinels),
so a field's shape holds inside the functions on one walker, and is checked there.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from beartype import BeartypeConf, beartype

_CHECKED = beartype(conf=BeartypeConf(is_pep484_tower=True))  # a whole number is a number, as PEP 484 says

F = TypeVar("F", bound=Callable)


def check(function: F) -> F:
    return function if function.__name__ == "__init__" else _CHECKED(function)
