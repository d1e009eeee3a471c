"""Configurations of before mean what they meant."""

import dataclasses
import json

import pytest

from jaxwalk.common import resources
from jaxwalk.common.errors import UserError
from jaxwalk.config import Config, of_dict, to_dict
from jaxwalk.config.formats import FORMAT
from jaxwalk.learn.policies import policy


def test_what_is_written_is_read_again():
    config = dataclasses.replace(Config(), kernels="off")
    assert of_dict(json.loads(json.dumps(to_dict(config)))) == config


def test_a_file_without_a_number_meant_rigid_legs_and_one_decision_a_step():
    before = of_dict({})
    assert (before.gait.form, before.physics.drives, before.physics.actuators) == (
        "rigid",
        "servo",
        "unlimited",
    )
    assert (before.gait.steps, before.task.replan) == ("told", 0)
    assert (before.gait.duration_nominal, before.gait.length_nominal) == (0.12, 0.633)
    assert before.observation == ("speed", "pitch", "zmp", "step_length", "pitch_rate")


NO_LAG = {"lag_push_off": 0.0, "lag_pitch": 0.0, "lag_capture": 0.0}


def test_heel_and_toe_had_one_number():
    before = of_dict({"physics": {"contact_timeconst": 0.01}})
    assert before.physics.heel_timeconst == before.physics.contact_timeconst == 0.01


@pytest.mark.parametrize("told", [{}, {"gait": {}, "task": {}}, {"gait": {"speed_desired": 1.2}}])
def test_in_the_second_format_policies_commanded_each_step_and_were_asked_in_every_window(told):
    before, now = of_dict({"format": 2, **told}), of_dict({"format": FORMAT, **told})
    assert (before.gait.steps, before.task.replan) == ("told", 1)
    assert before.observation == (
        "speed", "speed_desired", "pitch", "elapsed", "capture_ahead", "swing_ahead",
    )  # fmt: skip
    assert before.gait.form == "compliant"
    limp = dataclasses.replace(
        now.gait.compliant, knee_stop=0.0, back_toe_off=1.0, toe_off_least=-1.0, landing_behind=100.0,
        balance_ankle=100.0, ankle_stop=0.0, balance_sole=100.0,
        length_speed=0.0, duration_speed=0.0, capture_speed=0.0, push_off_speed=0.0, **NO_LAG,
    )  # fmt: skip
    assert before.circumstances.share == 0.0 and before.train.height_spread == 0.1
    plan = dataclasses.replace(now.gait.step_plan, pitch_least=-10.0, back_latest=0.0, back_beyond=1.0)
    assert before.gait == dataclasses.replace(now.gait, steps="told", compliant=limp, step_plan=plan)
    assert (before.ddpg.return_steps, before.reward.zmp_weight, before.pushes.focus) == (1, 0.1, 0.0)


def test_in_the_third_format_a_leg_stepped_back_as_it_swung():
    told = {"pitch_gain": 1.2, "knee": 0.7, "knee_stiffness": 12.0, "knee_damping": 0.9}
    swing = {f"swing_{name}": number for name, number in told.items()}
    before = of_dict({"format": 3, "gait": {"compliant": swing}}).gait.compliant
    assert {name: getattr(before, f"back_{name}") for name in told} == told
    assert (before.back_toe_off, before.balance_ankle, before.ankle_stop) == (1.0, 100.0, 0.0)
    assert (before.length_speed, before.duration_speed, before.capture_speed, before.push_off_speed) == (
        0,
    ) * 4
    assert of_dict({"format": 3, "gait": {"toe_off_form": "paper"}}).gait.toe_off_form == "one-leg"


def test_in_the_fourth_format_walkers_balanced_on_the_edge_of_a_heel():
    before, now = of_dict({"format": 4}), of_dict({"format": FORMAT})
    legs = dataclasses.replace(now.gait.compliant, balance_sole=100.0, **NO_LAG)
    plan = dataclasses.replace(now.gait.step_plan, back_beyond=1.0)
    assert before.gait == dataclasses.replace(now.gait, compliant=legs, step_plan=plan)
    assert (before.ddpg.privileged, before.ddpg.hidden, before.train.footsteps) == (False, (128, 128), 40_000)


def test_in_the_fifth_format_nothing_told_of_a_pack():
    before, now = of_dict({"format": 5}), of_dict({"format": FORMAT})
    legs = dataclasses.replace(now.gait.compliant, **NO_LAG)
    assert before.gait == dataclasses.replace(now.gait, compliant=legs)


def test_in_the_sixth_format_pushes_came_at_any_time():
    before, now = of_dict({"format": 6}), of_dict({"format": FORMAT})
    assert (before.pushes.rest, before.pushes.soon, before.ddpg.noise_seconds) == (0.0, 0.0, 0.0)
    assert (before.circumstances.share, before.circumstances.late) == (0.5, 2)
    assert (before.train.walkers, before.train.footsteps, before.ddpg.action_weight) == (256, 100_000, 4.0)
    assert before.gait == now.gait


def test_what_a_file_of_the_second_format_says_is_kept():
    before = of_dict({"format": 2, "task": {"replan": 4}, "observation": ["pitch"]})
    assert (before.task.replan, before.observation, before.gait.steps) == (4, ("pitch",), "told")


def test_what_a_file_says_is_kept():
    told = {"gait": {"duration_nominal": 0.1}, "observation": ["speed"]}
    before = of_dict(told)
    assert before.gait.duration_nominal == 0.1
    assert before.observation == ("speed",)
    assert told == {"gait": {"duration_nominal": 0.1}, "observation": ["speed"]}


def test_todays_files_lack_nothing_that_is_not_todays_default():
    assert of_dict({"format": FORMAT}) == Config()


def test_the_rigid_policy_is_of_the_first_format():
    kept = policy.load(resources.model_path("shipped-rigid.safetensors"))
    told = json.loads(kept.metadata.config)
    assert "format" not in told
    assert (of_dict(told).gait.form, of_dict(told).gait.steps) == ("rigid", "told")


@pytest.mark.parametrize("number", [0, FORMAT + 1, str(FORMAT), None, True])
def test_a_format_that_is_not_known_is_refused(number):
    with pytest.raises(UserError, match=f"this version reads 1 to {FORMAT}"):
        of_dict({"format": number})
