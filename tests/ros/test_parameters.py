"""Parameters of the nodes: named where they are no good."""

from __future__ import annotations

import math

import pytest

from jaxwalk.common.errors import UserError
from jaxwalk.ros import parameters


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ({"bodi": "x"}, "unknown parameter bodi: give some of body, method"),
        ({}, "parameter body is missing"),
        ({"body": "x", "lockstep": "yes"}, "parameter lockstep: 'yes' is no bool"),
        ({"body": 3}, "parameter body: 3 is no str"),
        ({"body": "x", "factor": True}, "parameter factor: True is no float"),
        (
            {"body": "x", "factor": 0.0},
            "node: parameter factor: 0.0 is out of range: give more than 0, finite",
        ),
        ({"body": "x", "factor": math.inf}, "parameter factor: inf is out of range"),
        ({"body": "x", "factor": math.nan}, "parameter factor: nan is out of range"),
        ({"body": "x", "factor": 10**400}, "parameter factor: 1000"),
        ({"body": "x", "method": "fast"}, "parameter method: 'fast' is out of range: give world or quick"),
        ({"body": "x", "patience": 0}, "parameter patience: 0 is out of range"),
        ({"body": "x", "seconds": -1.0}, "parameter seconds: -1.0 is out of range: give 0 or more, finite"),
        ({"body": "x", "listeners": 0}, "parameter listeners: 0 is out of range: give 1 or more"),
        (
            {"body": "x", "report": "/nowhere/at/all.json"},
            "node: parameter report /nowhere/at/all.json: there is",
        ),
        ({"body": "x", "report": "/tmp"}, "node: parameter report /tmp: is a folder"),
    ],
)
def test_parameters_that_are_no_good_are_named(told, said):
    with pytest.raises(UserError, match=said):
        parameters.read(parameters.Simulated, told, "node")


@pytest.mark.parametrize(
    ("kind", "told", "said"),
    [
        (parameters.Controlled, {"delay": 0.05}, "delay: 0.05 is out of range: give 0 or more, 0.04 at most"),
        (parameters.Controlled, {"factor": -1.0}, "factor: -1.0 is out of range"),
        (
            parameters.Controlled,
            {"commands": "/nowhere/at/all"},
            "commands /nowhere/at/all: there is no folder",
        ),
        (parameters.Pushed, {"impulse": math.inf}, "impulse: inf is out of range: give a finite number"),
        (parameters.Pushed, {"begin": -0.1}, "begin: -0.1 is out of range"),
        (parameters.Pushed, {"seconds": 0.0}, "seconds: 0.0 is out of range"),
        (parameters.Pushed, {"patience": 0.0}, "patience: 0.0 is out of range"),
    ],
)
def test_ranges_of_the_other_nodes(kind, told, said):
    needed = {
        parameters.Controlled: {"policy": "p", "body": "b"},
        parameters.Pushed: {"impulse": 1, "begin": 0},
    }
    assert parameters.read(kind, needed[kind], "node")
    with pytest.raises(UserError, match=f"node: parameter {said}"):
        parameters.read(kind, needed[kind] | told, "node")
