"""Configurations go out to JSON and come back, and senseless ones are refused."""

import dataclasses
import json
from dataclasses import dataclass
from typing import Literal

import pytest

from jaxwalk.common.errors import UserError
from jaxwalk.config import Config, DDPGConfig, of_dict, to_dict, validate
from jaxwalk.config.presets import PRESETS


@pytest.mark.parametrize("name", PRESETS)
def test_presets_are_sound_and_survive_json(name):
    config = PRESETS[name]
    validate.check(config)
    assert of_dict(json.loads(json.dumps(to_dict(config)))) == config


def test_the_paper_preset_holds_the_papers_constants():
    ddpg = PRESETS["paper"].ddpg
    assert ddpg.hidden == (400, 300)
    assert (ddpg.actor_lr, ddpg.critic_lr, ddpg.gamma) == (1e-8, 2e-8, 0.99)
    assert (ddpg.batch_size, ddpg.replay_capacity) == (32, 70_000)
    assert not (ddpg.layer_norm or ddpg.normalize_observations or ddpg.twin)
    assert PRESETS["paper"].body.table == "box"


def test_missing_fields_take_their_defaults():
    config = of_dict({"format": 2, "ddpg": {"gamma": 0.5}})
    assert config == Config(ddpg=DDPGConfig(gamma=0.5))


def test_whole_numbers_serve_as_floats():
    height = of_dict({"body": {"height": 2}}).body.height
    assert (height, type(height)) == (2.0, float)


@pytest.mark.parametrize(
    ("data", "says"),
    [
        ({"ddpg": {"gama": 0.5}}, ["unknown field ddpg.gama", "gamma"]),
        ({"legs": 3}, ["unknown field legs"]),
        ({"ddpg": 3}, ["ddpg", "table"]),
        ([], ["Config", "table"]),
        ({"ddpg": {"gamma": "high"}}, ["ddpg.gamma = 'high'", "float"]),
        ({"ddpg": {"gamma": True}}, ["ddpg.gamma = True", "float"]),
        ({"ddpg": {"batch_size": 2.5}}, ["ddpg.batch_size = 2.5", "int"]),
        ({"ddpg": {"layer_norm": 1}}, ["ddpg.layer_norm = 1", "bool"]),
        ({"ddpg": {"hidden": 400}}, ["ddpg.hidden = 400", "list"]),
        ({"ddpg": {"hidden": [400, "x"]}}, ["ddpg.hidden[1] = 'x'", "int"]),
        ({"body": {"table": "round"}}, ["body.table = 'round'", "winter, box"]),
        ({"observation": ["mood"]}, ["observation[0] = 'mood'", "pitch"]),
    ],
)
def test_a_wrong_value_is_named(data, says):
    with pytest.raises(UserError) as caught:
        of_dict(data)
    for part in says:
        assert part in str(caught.value)


def test_any_dataclass_can_be_decoded():
    @dataclass(frozen=True)
    class Other:
        mode: Literal["a", "b"]
        bound: float | None = 1.0

    assert validate.from_dict(Other, {"mode": "b", "bound": None}) == Other("b", None)


@pytest.mark.parametrize(
    ("part", "changes", "option"),
    [
        ("ddpg", {"tau": 0.0}, "--ddpg.tau"),
        ("ddpg", {"hidden": ()}, "--ddpg.hidden"),
        ("ddpg", {"gamma": -0.1}, "--ddpg.gamma"),
        ("physics", {"timestep": 0.0}, "--physics.timestep"),
        ("sensors", {"noise": -1.0}, "--sensors.noise"),
        ("pushes", {"rate": float("inf")}, "--pushes.rate"),
        ("gait", {"length_min": 2.0}, "--gait.length-nominal"),
        ("gait", {"duration_min": 0.0}, "--gait.duration-nominal"),
        ("train", {"mass_spread": 1.0}, "--train.mass-spread"),
        ("body", {"height": 0.1}, "height 0.1"),
    ],
)
def test_a_senseless_configuration_is_refused(part, changes, option):
    config = Config()
    changed = dataclasses.replace(config, **{part: dataclasses.replace(getattr(config, part), **changes)})
    with pytest.raises(UserError, match=option):
        validate.check(changed)
