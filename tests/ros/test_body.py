"""A body's file: read as it was written, or refused in one line."""

from __future__ import annotations

import json

import pytest

from jaxwalk.common.errors import UserError
from jaxwalk.ros import body as bodies


def test_a_body_is_read_as_it_was_written(body, tmp_path):
    (tmp_path / "body.json").write_text(bodies.text(body))
    again = bodies.read(tmp_path / "body.json")
    assert bodies.text(again) == bodies.text(body)
    assert all((getattr(again, name) == getattr(body, name)).all() for name in ("qpos", "qvel", "touch"))
    assert body.joints == ("hip_left", "knee_left", "ankle_left", "hip_right", "knee_right", "ankle_right")


@pytest.mark.parametrize("broken", ["[]", "{", "tree", "start", "mass", "stance", "foot"])
def test_a_damaged_body_is_told_in_one_line(body, tmp_path, broken):
    told = json.loads(bodies.text(body))
    if broken in told:
        del told[broken]
    told.get("tree", {}).update({"mass": [1.0]} if broken == "mass" else {})
    told.get("tree", {}).update({"foot": [3, 3, 6, 9]} if broken == "foot" else {})
    told.get("start", {}).update({"stance": 2} if broken == "stance" else {})
    text = broken if broken in ("[]", "{") else json.dumps(told)
    (tmp_path / "body.json").write_text(text)
    with pytest.raises(UserError, match=r"give the body\.json that jaxwalk ros writes"):
        bodies.read(tmp_path / "body.json")


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("parent", lambda told: [-2, *told[1:]]),
        ("parent", lambda told: [told[0], -1, *told[2:]]),
        ("driven", lambda told: [0, *told[1:]]),
        ("driven", lambda told: [told[1], *told[1:]]),
        ("turn", lambda told: [0.5, *told[1:]]),
        ("imu", lambda told: [*told, 0.0]),
        ("imu", lambda told: [told]),
        ("soles", lambda told: told[:1]),
        ("anchor", lambda told: [[*row, 0.0] for row in told]),
        ("mass", lambda told: [[one] for one in told]),
        ("mass", lambda told: [1e-10, *told[1:]]),
        ("inertia", lambda told: [1e-10, *told[1:]]),
        ("damping", lambda told: [*told[:-1], -0.1]),
        ("friction", lambda told: -0.1),
        ("timestep", lambda told: 0.02),
        ("timestep", lambda told: 1e-5),
    ],
)
def test_a_tree_that_ode_cannot_hold_is_told_in_one_line(body, tmp_path, name, value):
    told = json.loads(bodies.text(body))
    told["tree"][name] = value(told["tree"][name])
    (tmp_path / "body.json").write_text(json.dumps(told))
    with pytest.raises(UserError, match="not of a body"):
        bodies.read(tmp_path / "body.json")


@pytest.mark.parametrize(
    "names",
    [
        ["a"] * 6,
        ["a", "b", "c", "d", "e"],
        ["a", "b", "c", "d", "e", "f g"],
        ["", *"bcdef"],
        [*"abcde", "/f"],
    ],
)
def test_joints_are_six_names_for_topics(body, tmp_path, names):
    told = json.loads(bodies.text(body)) | {"joints": names}
    (tmp_path / "body.json").write_text(json.dumps(told))
    with pytest.raises(UserError, match="not of a body"):
        bodies.read(tmp_path / "body.json")


def test_five_joints_are_none_even_where_all_parts_agree(body, tmp_path):
    told = json.loads(bodies.text(body))
    for name in ("driven", "gain", "offset", "rate", "limit"):
        told["tree"][name].pop()
    told["joints"].pop()
    (tmp_path / "body.json").write_text(json.dumps(told))
    with pytest.raises(UserError, match="not of a body"):
        bodies.read(tmp_path / "body.json")
