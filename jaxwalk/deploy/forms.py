"""The two kinds of controllers, behind one face: how a step begins, what joints are told, how it goes on."""

from __future__ import annotations

from types import ModuleType

from jaxwalk.config import GaitConfig
from jaxwalk.deploy.compliant import form as compliant
from jaxwalk.deploy.rigid import form as rigid

_FORMS = {"rigid": rigid, "compliant": compliant}


def of(config: GaitConfig) -> ModuleType:
    """The controllers that ``config`` names: a module with

    ``start(who, gravity, posture, estimate, stance) -> Clock``,
    ``command(who, gravity, posture, clock, estimate) -> [6]``,
    ``proceed(who, gravity, posture, clock, estimate, timestep) -> (Clock, landed)``, after each tick, and
    ``let_go(said) -> [6]``, a command that moves nothing.
    """
    return _FORMS[config.form]
