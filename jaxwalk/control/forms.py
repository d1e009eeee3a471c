"""The two kinds of controllers, behind one face: how a step begins, what joints are told, how it goes on."""

from __future__ import annotations

from types import ModuleType

from jaxwalk.config import GaitConfig
from jaxwalk.control.compliant import form as compliant
from jaxwalk.control.rigid import form as rigid

_FORMS = {"rigid": rigid, "compliant": compliant}


def of(config: GaitConfig) -> ModuleType:
    """The controllers that ``config`` names: a module with

    ``start(setup, person, bones, estimate, stance) -> StepClock``,
    ``command(setup, person, bones, clock, estimate) -> [6]``, rigid: for servos, compliant: torques, N m, and
    ``proceed(setup, person, bones, clock, estimate) -> (StepClock, landed)``, after each tick.
    """
    return _FORMS[config.form]
