"""What results say of their origin."""

from __future__ import annotations

import json

import pytest

from jaxwalk.config import to_dict
from jaxwalk.learn.policies import named, provenance


@pytest.fixture(scope="module")
def shipped():
    return named.load("shipped")


@pytest.fixture
def told(shipped):
    return {"policy_digest": shipped.digest, "config": json.loads(json.dumps(to_dict(shipped.config)))}


def test_results_are_of_the_policy_and_configuration_that_they_name(shipped, told):
    assert provenance.is_of(told, shipped)
    assert not provenance.is_of(told | {"policy_digest": "another"}, shipped)
    told["config"]["body"]["height"] += 0.1
    assert not provenance.is_of(told, shipped)


def test_a_field_that_is_younger_than_the_results_had_its_default(shipped, told):
    del told["config"]["train"]["checkpoint_seconds"]
    assert provenance.is_of(told, shipped)


@pytest.mark.parametrize("config", [None, [], "x", {"body": {"heigth": 1.8}}])
def test_a_damaged_configuration_is_of_nobody(shipped, told, config):
    assert not provenance.is_of(told | {"config": config}, shipped)
