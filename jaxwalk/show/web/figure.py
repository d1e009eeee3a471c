"""The walker as it is drawn from its right side: bodies and outlines in the plane, from the model's geoms."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from jaxwalk.model import mjcf

_FAR, _NEAR = mjcf.SIDES  # seen from the right, the left leg is the far one
_PITCHES = ("root_pitch", "hip", "knee", "ankle")  # what a body turns by in the plane
_TRUNK = (("block", "torso", "head", "head"), ("block", "torso", "trunk", "trunk"))


def figure(model: mujoco.MjModel) -> dict[str, Any]:
    """Plain JSON values, m and rad.

    ``bodies``: in the order of `mjcf.SEGMENTS`, each with its ``parent`` (-1: the floor), the place
    (``x``, ``z``) of its joint in that one and ``turn``, 1 or -1: in which sense its angle turns it.
    ``shapes``: from the back to the front, each with its ``body``, ``kind`` and ``colour``; a ``block`` or
    ``limb`` has a centre (``x``, ``z``) and half sizes (``half_x``, ``half_z``), a ``foot`` the ``points``
    that its outline runs around at the distance ``radius``.
    ``imu``: (x, z) in the torso. ``depth``: of half the trunk.
    """
    legs = {side: [(part, side) for part in ("thigh", "shank", "foot")] for side in mjcf.SIDES}
    shapes = [_of_leg(model, part, side, "far") for part, side in legs[_FAR]]
    shapes += [_box(model, *parts) for parts in _TRUNK]
    shapes += [_of_leg(model, part, side, "near") for part, side in legs[_NEAR]]
    return {
        "bodies": [_body(model, name) for name in mjcf.SEGMENTS],
        "shapes": shapes,
        "imu": _plane(model.site("imu").pos),
        "depth": float(model.geom("trunk").size[0]),
    }


def _plane(vector: np.ndarray) -> list[float]:
    return [round(float(vector[0]), 5), round(float(vector[2]), 5)]


def _body(model: mujoco.MjModel, name: str) -> dict[str, Any]:
    body = model.body(name)
    x, z = _plane(body.pos)
    joints = range(int(body.jntadr[0]), int(body.jntadr[0]) + int(body.jntnum[0]))
    (turn,) = (np.sign(model.jnt_axis[i][1]) for i in joints if model.joint(i).name.startswith(_PITCHES))
    parent = -1 if name == mjcf.SEGMENTS[0] else mjcf.SEGMENTS.index(model.body(int(body.parentid[0])).name)
    return {"name": name, "parent": parent, "x": x, "z": z, "turn": int(turn)}


def _box(model: mujoco.MjModel, kind: str, body: str, geom: str, colour: str) -> dict[str, Any]:
    box = model.geom(geom)
    x, z = _plane(box.pos)
    half_x, half_z = _plane(box.size)
    segment = mjcf.SEGMENTS.index(body)
    return {
        "kind": kind,
        "body": segment,
        "colour": colour,
        "x": x,
        "z": z,
        "half_x": half_x,
        "half_z": half_z,
    }


def _of_leg(model: mujoco.MjModel, part: str, side: str, colour: str) -> dict[str, Any]:
    name = f"{part}_{side}"
    if part != "foot":
        return _box(model, "limb", name, name, colour)
    flat = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, f"toe_{side}") >= 0
    corner = "" if flat else "_outer"  # between walls a sole has four
    ends = [model.geom(f"{end}{corner}_{side}") for end in ("toe", "heel")]
    points = [[0.0, 0.0], *(_plane(end.pos) for end in ends)]  # the ankle, and what touches the floor
    radius = round(float(ends[0].size[0]), 5)
    segment = mjcf.SEGMENTS.index(name)
    return {"kind": "foot", "body": segment, "colour": colour, "points": points, "radius": radius}
