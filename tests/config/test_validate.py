"""Configurations go out to JSON and come back, and senseless ones are refused."""

import dataclasses
import json
from dataclasses import dataclass
from typing import Literal

import pytest

from jaxwalk.common.errors import UserError
from jaxwalk.config import CompliantConfig, Config, DDPGConfig, StepPlanConfig, of_dict, to_dict, validate
from jaxwalk.config.formats import FORMAT
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
    config = of_dict({"format": FORMAT, "ddpg": {"gamma": 0.5}})
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
        ({"gait": {"steps": "guessed"}}, ["gait.steps = 'guessed'", "told, planned"]),
        ({"gait": {"step_plan": 0.2}}, ["gait.step_plan", "table"]),
        ({"gait": {"step_plan": {"gain": 1}}}, ["unknown field gait.step_plan.gain", "length_gain"]),
        ({"gait": {"step_plan": {"back_time": None}}}, ["gait.step_plan.back_time = None", "float"]),
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
        ("gait", {"steps": "guessed"}, "--gait.steps guessed: give one of told, planned"),
        ("train", {"mass_spread": 1.0}, "--train.mass-spread"),
        ("body", {"height": 0.1}, "height 0.1"),
    ],
)
def test_a_senseless_configuration_is_refused(part, changes, option):
    refused(Config(), part, changes, option)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"change_length": 0.0}, "--gait.step-plan.change-length 0.0: give a number above 0"),
        ({"change_duration": -0.1}, "--gait.step-plan.change-duration -0.1: give a number above 0"),
        ({"back_speed": 0.0}, "--gait.step-plan.back-speed 0.0: give a number above 0"),
        ({"pitch_gain": float("nan")}, "--gait.step-plan.pitch-gain nan: give a finite number"),
        (
            {"duration_least": 0.8},
            "--gait.step-plan.duration-least 0.8: give at most --gait.step-plan.duration-most, 0.7",
        ),
        (
            {"back_soonest": 0.4, "back_time": 0.3},
            "--gait.step-plan.back-soonest 0.4: give at most --gait.step-plan.back-time, 0.3",
        ),
    ],
)
def test_a_senseless_step_plan_is_refused(changes, says):
    refused(Config(), "gait", {"step_plan": StepPlanConfig(**changes)}, says)


@pytest.mark.parametrize("name", ["lag_seconds", "lag_speed", "lag_most"])
def test_a_lag_is_divided_by_and_bounded(name):
    says = f"--gait.compliant.{name.replace('_', '-')} 0.0: give a number above 0"
    refused(Config(), "gait", {"compliant": CompliantConfig(**{name: 0.0})}, says)


def test_rigid_legs_do_not_plan_their_steps():
    refused(PRESETS["rigid"], "gait", {"steps": "planned"}, "--gait.steps planned: give told: rigid legs")


def refused(config, part, changes, says):
    """In one line that says what is wrong."""
    changed = dataclasses.replace(config, **{part: dataclasses.replace(getattr(config, part), **changes)})
    with pytest.raises(UserError) as caught:
        validate.check(changed)
    assert says in str(caught.value) and "\n" not in str(caught.value)
