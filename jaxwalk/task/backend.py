"""What carries walkers from tick to tick: native code made of the tick, a GPU's kernels, or XLA."""

from __future__ import annotations

import dataclasses
import functools
import sys
from collections.abc import Callable, Hashable
from typing import Any, TypeVar

import jax

from jaxwalk.common.parallel import devices
from jaxwalk.config import Config, Engine
from jaxwalk.kernels import native, walk
from jaxwalk.kernels.compiler import BuildError
from jaxwalk.kernels.graph import Unsupported
from jaxwalk.model.engine import Setup, on_gpu, unrolls

T = TypeVar("T")
BLOCK = 128
"""Walkers that native code moves between two questions to the policy: fewer are too few for XLA."""


def scan(
    setup: Setup,
    function: Callable[..., tuple[Any, Any]],
    setting: Hashable,
    length: int,
    state: Any,
    *constants: Any,
    otherwise: Callable[[], tuple[Any, Any]],
) -> tuple[Any, Any]:
    """One walker, ``length`` times ``function(setting, state, *constants)``; the state, and the rows written.

    Args:
      setup: of the walkers. function: gives the new state and a row; of a module's level.
      otherwise: the same by other means, where there is no native code.
    """
    if native_here(setup):
        try:
            return walk.scan(function, setting, length, state, *constants)
        except (BuildError, Unsupported) as why:
            say(f"no native code, XLA steps instead, much slower: {why}")
            if isinstance(why, BuildError):
                _failed.append(str(why))
    return otherwise()


def block(setup: Setup) -> int:
    """Walkers that a device moves together, the policy included: all programs move blocks of this size, so
    that a walk is the same, bit for bit, however many others walk."""
    if native_here(setup):
        return BLOCK
    return devices.BLOCK if jax.default_backend() == "cpu" else 1


def each(setup: Setup, function: Callable[..., Any], *walkers: Any) -> Any:
    """``function``, which steps one walker without asking its policy, for all: see `devices.each`."""
    # In native code a walker is moved alike in any company.
    return jax.vmap(function)(*walkers) if native_here(setup) else devices.each(function, *walkers)


def native_here(setup: Setup) -> bool:
    """Whether walkers of ``setup`` are stepped by native code, as far as is known before it is made."""
    return unrolls(setup) and jax.default_backend() == "cpu" and problem() is None


def problem() -> str | None:
    """Why this machine has no native code; None: it has, so far."""
    return _failed[0] if _failed else _probed()


@functools.cache
def _probed() -> str | None:
    try:
        native.width()
    except BuildError as why:
        return str(why)
    return None


_failed: list[str] = []  # what kept the first library from being made that was needed


_OTHERS = {"mujoco": "C MuJoCo", "ode": "ODE's world step", "ode-quick": "ODE's quick step"}


def stepper_of(config: Config, engine: Engine = "mjx") -> str:
    """What steps walkers of ``config`` here, in a few words."""
    setup = Setup.of(config, engine)
    if engine in _OTHERS:
        return _OTHERS[engine]
    if native_here(setup):
        return f"native code, {native.width()} walkers a vector"
    if on_gpu(setup):
        return "kernels of the GPU"
    if config.physics.solver == "mjx":
        return "mjx.step"
    if jax.default_backend() == "cpu" and unrolls(setup):
        return f"XLA ({problem()})"
    return "XLA"


def begin(config: Config, engine: Engine = "mjx") -> None:
    """Says what steps, the first line of a command that measures."""
    print(f"stepped by {stepper_of(config, engine)}", flush=True)


def sized(args: T, config: Config, many: int, few: int) -> T:
    """A command's options with as many ``replicas`` as are asked for; else ``many`` where native code steps
    the walkers of ``config``, ``few`` elsewhere.

    Args:
      args: a dataclass with ``replicas`` and ``engine``.
    """
    told: Any = args
    if told.replicas is not None:
        return args
    here = native_here(Setup.of(config, told.engine))
    return dataclasses.replace(told, replicas=many if here else few)


@functools.cache
def say(text: str) -> None:
    """One line for whoever started the program, once."""
    print(f"jaxwalk: {text}", file=sys.stderr, flush=True)
