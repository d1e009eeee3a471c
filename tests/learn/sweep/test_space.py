"""What --set says, and that nonsense is refused in one line."""

from __future__ import annotations

import pytest

from jaxwalk.common.errors import UserError
from jaxwalk.config.presets import PRESETS
from jaxwalk.learn.sweep import space
from jaxwalk.learn.sweep.space import Choice, Range

CONFIG = PRESETS["quick"]


def test_ranges_and_values():
    texts = [
        "ddpg.actor-lr=1e-5:1e-3:log",
        "--ddpg.batch_size=32:256",
        "ddpg.hidden=64  64|128 128",
        "train.walkers=128, 256",
        "ddpg.twin=True,False",
    ]
    assert space.parse(texts, CONFIG) == (
        Range("ddpg.actor_lr", 1e-5, 1e-3, log=True, whole=False),
        Range("ddpg.batch_size", 32, 256, log=False, whole=True),
        Choice("ddpg.hidden", ("64 64", "128 128")),
        Choice("train.walkers", ("128", "256")),
        Choice("ddpg.twin", ("True", "False")),
    )


def test_values_reach_the_configuration_as_what_they_are():
    values = {"ddpg.actor_lr": 2e-4, "ddpg.hidden": "128 64", "ddpg.twin": "True", "train.walkers": "64"}
    config = space.changed(CONFIG, {**values, "ddpg.start": "random", "observation": "speed pitch"})
    assert (config.ddpg.actor_lr, config.ddpg.hidden, config.ddpg.twin) == (2e-4, (128, 64), True)
    assert (config.train.walkers, config.ddpg.start) == (64, "random")
    assert config.observation == ("speed", "pitch")
    assert config.train.footsteps == CONFIG.train.footsteps and config.gait == CONFIG.gait


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("ddpg.gama=0.1:0.3", "no option ddpg.gama, perhaps ddpg.gamma"),
        ("ddpg=1:2", "no option ddpg"),
        ("ddpg.gamma", "give OPTION=LOW:HIGH"),
        ("ddpg.gamma=", "give OPTION=LOW:HIGH"),
        ("ddpg.gamma=0.9:0.7", "LOW must be below HIGH"),
        ("ddpg.gamma=0.1:nan", "LOW must be below HIGH"),
        ("ddpg.gamma=a:b", "give numbers for LOW and HIGH"),
        ("ddpg.gamma=0.9:1.7", "--ddpg.gamma 1.7: give a number from 0"),
        ("ddpg.gamma=0.1:0.2:lin", "LOW:HIGH:log"),
        ("ddpg.actor-lr=0:1:log", "above 0"),
        ("train.walkers=1.5:3", "whole numbers"),
        ("train.walkers=1.5,3", "a value of type int"),
        ("ddpg.twin=Yes,No", "a value of type bool"),
        ("ddpg.hidden=64 x|3", "a value of type int"),
        ("ddpg.start=nominal,mad", "give one of nominal, random"),
        ("ddpg.gamma=0.5", "two values or more"),
        ("ddpg.gamma=0.5,,0.6", "without gaps"),
        ("ddpg.gamma=0.5,0.5", "each once"),
    ],
)
def test_nonsense_is_refused(text, told):
    with pytest.raises(UserError) as refused:
        space.parse([text], CONFIG)
    said = str(refused.value)
    assert said.startswith(f"--set {text}: ") and told in said and "\n" not in said


def test_an_option_given_twice_and_none():
    with pytest.raises(UserError, match="give each option once"):
        space.parse(["ddpg.gamma=0.5,0.6", "ddpg.gamma=0.1:0.2"], CONFIG)
    with pytest.raises(UserError, match="one or more options"):
        space.parse([], CONFIG)
