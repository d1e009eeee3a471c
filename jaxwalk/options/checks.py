"""Checks that several commands make of their options."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from typing import Any

from jaxwalk.common import runtime
from jaxwalk.common.errors import UserError
from jaxwalk.config import REFERENCE_HEIGHT, REFERENCE_MASS, BodyConfig, validate

_WALKER = 4096  # bytes of a walker's results, at least
_REPLAYED = 12  # a page stays below a megabyte
TRAINED = ("shipped", "shipped-rigid")
"""Policies that come with the package: the best, and the best on rigid legs, until format 1."""
BUILT_IN = (*TRAINED, "fixed", "constant", "raibert", "capture-point", "replan")


def policy(name: str) -> None:
    """POLICY names something that exists. Its content is judged by whoever loads it."""
    if name not in BUILT_IN and not os.path.exists(name):
        names = f"{', '.join(BUILT_IN[:-1])} or {BUILT_IN[-1]}"
        raise UserError(f"no policy {name!r}: give a run folder, a policy file, {names}")


def whole(option: str, value: int, least: int = 1) -> None:
    """A whole number, ``least`` or more."""
    if value < least:
        raise UserError(f"{option} {value}: give a whole number, {least} or more")


def walkers(option: str, count: int) -> None:
    """So many walkers as results of can be held in memory, at least 1."""
    whole(option, count)
    most = runtime.memory_left() // _WALKER
    if count > most:
        raise UserError(f"{option} {count}: more than the memory holds; give {most} at most")


def replicas(value: int | None) -> None:
    """Walkers for each push, if they are given."""
    if value is not None:
        whole("--replicas", value)


def seed(value: int) -> None:
    """What JAX's random keys are made of: 32 bits."""
    if not 0 <= value < 2**32:
        raise UserError(f"--seed {value}: give a whole number, 0 to {2**32 - 1}")


def walk_seconds(value: float) -> None:
    """How long walkers are watched; what is counted begins once they have settled."""
    between("--seconds", value, 5.0, 3600.0, " s, the first 3 not being measured")


def between(option: str, value: int | float, low: int | float, high: int | float, unit: str) -> None:
    """A finite number within [low, high]."""
    if not low <= value <= high:
        raise UserError(f"{option} {value:g}: give {low:g} to {high:g}{unit}")


def positive(option: str, value: float, unit: str) -> None:
    """A finite number of ``unit`` above 0."""
    if not (math.isfinite(value) and value > 0):
        raise UserError(f"{option} {value:g}: give a number of {unit} above 0")


def ascending(option: str, values: Sequence[float]) -> None:
    """Numbers in ascending order, each once."""
    if list(values) != sorted(set(values)):
        shown = ",".join(f"{value:g}" for value in values)
        raise UserError(f"{option} {shown}: give ascending numbers, each once")


def impulses(option: str, values: Sequence[float]) -> None:
    """Pushes, N s, in any order."""
    for value in values:
        if not 0 < abs(value) <= 1000:
            raise UserError(f"{option} {value:g}: give -1000 to 1000 N s, and not 0")
    if len(set(values)) < len(values):
        raise UserError(f"{option} {','.join(f'{value:g}' for value in values)}: give each impulse once")


def replayed(values: Sequence[float]) -> None:
    """Pushes that a page replays."""
    impulses("--impulses", values)
    if len(values) > _REPLAYED:
        raise UserError(f"--impulses with {len(values)}: give {_REPLAYED} at most")


def push_seconds(option: str, value: float) -> None:
    """A push's duration; what lasts longer is a load."""
    between(option, value, 0.001, 2.0, " s")


def walker(options: Any) -> None:
    """The walker that a command's options ask for: its speed, stature, mass and noise."""
    if options.speed is not None:
        between("--speed", options.speed, 0.1, 3.0, " m/s")
    person(options.height, options.mass)
    between("--noise", options.noise, 0.0, 100.0, "")


def person(height: float | None, mass: float | None) -> None:
    """A stature and a mass, each if given, that people have."""
    validate.person(
        BodyConfig(
            height=REFERENCE_HEIGHT if height is None else height,
            mass=REFERENCE_MASS if mass is None else mass,
        )
    )
