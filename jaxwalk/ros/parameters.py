"""The nodes' private parameters, as they come from YAML, a launch file or the command line."""

from __future__ import annotations

import dataclasses
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar, cast

from jaxwalk.common import files
from jaxwalk.common.errors import UserError
from jaxwalk.config import DELAY_MOST

T = TypeVar("T")
_MOST = sys.float_info.max  # what is more, or not a number, is not finite
_LONGEST = 1e6  # s; ROS's times have an end, too


@dataclass(frozen=True)
class Wanted:
    """What a parameter may be.

    Attributes:
      least, most: of a number. above: more than ``least``. names: of which a text is one.
      written: a text names a file for results, where it is not empty.
    """

    least: float = -_MOST
    most: float = _MOST
    above: bool = False
    names: tuple[str, ...] = ()
    written: bool = False

    def takes(self, value: Any) -> bool:
        """Whether ``value`` is one, as far as can be said without looking at files."""
        if isinstance(value, bool | str):
            return not self.names or value in self.names
        return self.least <= value <= self.most and not (self.above and value == self.least)

    def __str__(self) -> str:
        if self.names:
            return " or ".join(self.names)
        if self.least == -_MOST:
            return "a finite number"
        least = f"more than {self.least:g}" if self.above else f"{self.least:g} or more"
        return f"{least}, finite" if self.most == _MOST else f"{least}, {self.most:g} at most"


def _one(wanted: Wanted, **default: Any) -> Any:
    return field(**default, metadata={"wanted": wanted})


_FACTOR = Wanted(least=0.0, above=True)
_PATIENCE = Wanted(least=0.0, above=True, most=_LONGEST)
_WRITTEN = Wanted(written=True)


@dataclass(frozen=True)
class Simulated:
    """Of the simulation node."""

    body: str
    """File of `jaxwalk.ros.body`."""
    method: str = _one(Wanted(names=("world", "quick")), default="world")
    """ODE's step: world or quick."""
    lockstep: bool = True
    """Each tick waits for its command; otherwise time runs by the clock."""
    factor: float = _one(_FACTOR, default=1.0)
    """Not in lock-step: simulated seconds a second."""
    seconds: float = _one(Wanted(least=0.0), default=0.0)
    """Simulated time after which it ends; 0: never."""
    listeners: int = _one(Wanted(least=1), default=1)
    """Subscribers of every sensor's topic that are waited for before the first tick."""
    patience: float = _one(_PATIENCE, default=2.0)
    """Lock-step: seconds by the clock that a command is waited for, before joints become passive."""
    report: str = _one(_WRITTEN, default="")
    """File for what was measured, JSON; empty for none."""


@dataclass(frozen=True)
class Controlled:
    """Of the controller node."""

    policy: str
    """An exported policy, .safetensors or .npz."""
    body: str
    """File of `jaxwalk.ros.body`: whose stance it starts in."""
    delay: float = _one(Wanted(least=0.0, most=DELAY_MOST), default=0.0)
    """By which the instruments of torso and soles tell late, s, as they were measured: the policy is told."""
    lockstep: bool = True
    """As the simulation's: the age of messages is counted in its time alone."""
    factor: float = _one(_FACTOR, default=1.0)
    """As the simulation's."""
    commands: str = _one(_WRITTEN, default="")
    """File for all commands, a line each; empty for none."""


@dataclass(frozen=True)
class Pushed:
    """Of the node that pushes."""

    impulse: float = _one(Wanted())
    """N s, forward positive."""
    begin: float = _one(Wanted(least=0.0, most=_LONGEST))
    """Simulated time at which it begins, s."""
    seconds: float = _one(Wanted(least=0.0, above=True, most=_LONGEST), default=0.1)
    """How long it lasts, s."""
    body: str = "torso"
    """The segment whose centre is pushed."""
    patience: float = _one(_PATIENCE, default=20.0)
    """Seconds by the clock that the simulation is waited for."""


def read(kind: type[T], told: Any, node: str) -> T:
    """``kind`` of what a node was told.

    Raises:
      UserError: an unknown name, one that is missing, a value of another type or out of range, or a file
        for results that cannot be written.
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
        _check(one.metadata.get("wanted", Wanted()), f"{node}: parameter {name}", value)
        made[name] = value
    return kind(**made)


def _check(wanted: Wanted, what: str, value: Any) -> None:
    if not wanted.takes(value):
        raise UserError(f"{what}: {value!r} is out of range: give {wanted}")
    if wanted.written and value:
        files.check_output(what, Path(value))
