"""The nodes' private parameters, as they come from YAML, a launch file or the command line."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, TypeVar, cast

from jaxwalk.common.errors import UserError

T = TypeVar("T")


@dataclass(frozen=True)
class Simulated:
    """Of the simulation node."""

    body: str
    """File of `jaxwalk.ros.body`."""
    method: str = "world"
    """ODE's step: world or quick."""
    lockstep: bool = True
    """Each tick waits for its command; otherwise time runs by the clock."""
    factor: float = 1.0
    """Not in lock-step: simulated seconds a second."""
    seconds: float = 0.0
    """Simulated time after which it ends; 0: never."""
    listeners: int = 1
    """Subscribers of every sensor's topic that are waited for before the first tick."""
    patience: float = 2.0
    """Lock-step: seconds by the clock that a command is waited for, before joints become passive."""
    report: str = ""
    """File for what was measured, JSON; empty for none."""


@dataclass(frozen=True)
class Controlled:
    """Of the controller node."""

    policy: str
    """An exported policy, .safetensors or .npz."""
    body: str
    """File of `jaxwalk.ros.body`: whose stance it starts in."""
    delay: float = 0.0
    """By which the instruments of torso and soles tell late, s, as they were measured: the policy is told."""
    lockstep: bool = True
    """As the simulation's: the age of messages is counted in its time alone."""
    factor: float = 1.0
    """As the simulation's."""
    commands: str = ""
    """File for all commands, a line each; empty for none."""


@dataclass(frozen=True)
class Pushed:
    """Of the node that pushes."""

    impulse: float
    """N s, forward positive."""
    begin: float
    """Simulated time at which it begins, s."""
    seconds: float = 0.1
    """How long it lasts, s."""
    body: str = "torso"
    """The segment whose centre is pushed."""
    patience: float = 20.0
    """Seconds by the clock that the simulation is waited for."""


def read(kind: type[T], told: Any, node: str) -> T:
    """``kind`` of what a node was told.

    Raises:
      UserError: an unknown name, one that is missing, or a value of another type.
    """
    fields = {one.name: one for one in dataclasses.fields(cast(Any, kind))}
    told = told if isinstance(told, dict) else {}
    for name in told:
        if name not in fields:
            raise UserError(f"{node}: unknown parameter {name}: give some of {', '.join(fields)}")
    made: dict[str, Any] = {}
    for name, one in fields.items():
        if name not in told:
            if one.default is dataclasses.MISSING:
                raise UserError(f"{node}: parameter {name} is missing")
            continue
        wanted = {"str": str, "bool": bool, "int": int, "float": (int, float)}[str(one.type)]
        value = told[name]
        if not isinstance(value, wanted) or (isinstance(value, bool) and one.type != "bool"):
            raise UserError(f"{node}: parameter {name}: {value!r} is no {one.type}")
        made[name] = value
    return kind(**made)
