"""The type checker of the tests: beartype on every call, but not on the making of dataclasses.

JAX rebuilds pytree dataclasses with whatever it maps over them (batches, specs, sentinels),
so a field's shape holds inside the functions on one walker, and is checked there.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import jaxtyping
from beartype import BeartypeConf, beartype

_CHECKED = beartype(conf=BeartypeConf(is_pep484_tower=True))  # a whole number is a number, as PEP 484 says
_JAXTYPED = jaxtyping.jaxtyped

F = TypeVar("F", bound=Callable)


def check(function: F) -> F:
    return function if function.__name__ == "__init__" else _CHECKED(function)


def install() -> None:
    """Check every call of what is imported from the package from now on."""
    jaxtyping.__dict__["jaxtyped"] = _jaxtyped
    jaxtyping.install_import_hook("jaxwalk", "typecheck.check")


def _jaxtyped(*, typechecker: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """As jaxtyping's, but that it looks for no shapes where a signature has none: to make a native program
    of a tick takes a million such calls, and would take twice the time."""

    def decorate(one: Any) -> Any:
        return typechecker(one) if _plain(one) else _JAXTYPED(one, typechecker=typechecker)

    return decorate


def _plain(one: Any) -> bool:
    """Whether it is a function without shapes, all of whose types exist while tests run."""
    if isinstance(one, type) or not hasattr(one, "__globals__") or "TYPE_CHECKING" in one.__globals__:
        return False
    return not any(quote in str(told) for told in one.__annotations__.values() for quote in "\"'")
