"""What the tests of the nodes and of their parts share."""

from __future__ import annotations

import numpy as np
import pytest

from jaxwalk.common.errors import UserError
from jaxwalk.config import Config
from jaxwalk.deploy import Controller
from jaxwalk.export import command as export
from jaxwalk.ode import library
from jaxwalk.ros import making
from jaxwalk.ros.watch import Keeper


@pytest.fixture(scope="session", autouse=True)
def ode():
    """Nothing of this can be tried where ODE is missing."""
    try:
        library.load()
    except UserError as missing:
        pytest.skip(str(missing))


@pytest.fixture(scope="module")
def body():
    return making.body(Config(), 0)


class Counting(Controller):
    """Says how often it has been asked since it began."""

    def __init__(self):
        self.asked, self.passive = 0, False

    @property
    def fallen(self):
        return False

    def start(self, said, stance):
        self.asked = 0
        return np.full(6, 100.0 + stance)

    def tick(self, said):
        self.asked += 1
        return np.full(6, float(self.asked))


@pytest.fixture
def said():
    return []


@pytest.fixture
def keeper(said):
    return Keeper(Counting(), 1, said.append)


@pytest.fixture(scope="module")
def policy(tmp_path_factory):
    """The file of the policy that is shipped."""
    trained, manifest = export.load("shipped")
    return export.write(trained, manifest, ("safetensors",), tmp_path_factory.mktemp("policy"))["safetensors"]


@pytest.fixture
def shipped(policy, body, said):
    return Keeper(Controller.load(policy), body.stance, said.append)
