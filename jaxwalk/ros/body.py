"""The file that the nodes know the walker by: its body for ODE, and where it starts."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from jaxwalk.common import untrusted
from jaxwalk.common.errors import UserError
from jaxwalk.ode import Tree

_CURE = "give the body.json that jaxwalk ros writes"
_WHOLE = ("parent", "foot", "soles", "driven")  # numbers of bodies
_SINGLE = ("timestep", "gravity", "friction")
JOINTS = 6
_NAME = re.compile("[A-Za-z][A-Za-z0-9_]*")  # what ROS takes for a part of a topic's name
_LEAST = 1e-9  # kg, kg m^2: ODE ends the process over less than its own numbers hold
_TICKS = 1e-5, 0.02  # s


@dataclass(frozen=True)
class Body:
    """A walker that has just landed.

    Attributes:
      tree: what ODE is told of it.
      qpos, qvel: [9] its joints and their rates at the start, m and rad.
      touch: [2] N under each sole then. stance: the foot that has landed, 0 left, 1 right.
      segments: [7] names of the tree's bodies. joints: [6] of those that are driven, left, then right.
    """

    tree: Tree
    qpos: np.ndarray
    qvel: np.ndarray
    touch: np.ndarray
    stance: int
    segments: tuple[str, ...]
    joints: tuple[str, ...]


def text(body: Body) -> str:
    """``body`` as JSON; `read` gives the same numbers back, bit for bit."""
    told = {one.name: np.asarray(getattr(body.tree, one.name)).tolist() for one in dataclasses.fields(Tree)}
    start = {name: getattr(body, name).tolist() for name in ("qpos", "qvel", "touch")}
    names = {"segments": body.segments, "joints": body.joints}
    return json.dumps({"tree": told, "start": start | {"stance": body.stance}, **names}, indent=1)


def read(path: str | os.PathLike[str]) -> Body:
    """The body in the file ``path``.

    Raises:
      UserError: no such file, or not one that `text` made.
    """
    told = untrusted.read_json(path, _CURE)
    try:
        start = told["start"]
        body = Body(
            tree=_tree(told["tree"]),
            qpos=np.array(start["qpos"], float),
            qvel=np.array(start["qvel"], float),
            touch=np.array(start["touch"], float),
            stance=int(start["stance"]),
            segments=tuple(map(str, told["segments"])),
            joints=tuple(map(str, told["joints"])),
        )
        _check(body)
    except (KeyError, TypeError, ValueError, IndexError, AttributeError):
        raise UserError(untrusted.unreadable(path, "not of a body", _CURE)) from None
    return body


def _tree(told: dict[str, Any]) -> Tree:
    made: dict[str, Any] = {}
    for one in dataclasses.fields(Tree):
        value = told[one.name]
        made[one.name] = (
            float(value) if one.name in _SINGLE else np.array(value, int if one.name in _WHOLE else float)
        )
    return Tree(**made)


def _check(body: Body) -> None:
    tree, count = body.tree, len(body.segments)
    per_body = tree.mass, tree.inertia, tree.turn, tree.damping
    per_ball = tree.radius, tree.stiffness, tree.yielding
    per_joint = tree.gain, tree.offset, tree.rate, tree.limit
    above, driven = tree.parent, tree.driven
    fits = (
        all(len(x) == count for x in (tree.parent, *per_body))
        and all(len(x) == len(tree.foot) for x in per_ball)
        and all(len(x) == len(driven) == len(body.joints) for x in per_joint)
        and all(x.ndim == 1 for x in (above, *per_body, *per_ball, *per_joint, tree.foot, driven))
        and all(x.shape == (count, 2) for x in (tree.anchor, tree.centre))
        and tree.ball.shape == (len(tree.foot), 2)
        and tree.imu.shape == tree.soles.shape == body.touch.shape == (2,)
        and len(body.qpos) == len(body.qvel) == count + 2
        # A root, and each of the others on one before it: the root's joint is driven by nothing.
        and above[0] == -1
        and (above[1:] >= 0).all()
        and (above < np.arange(count)).all()
        and (driven >= 1).all()
        and len(set(driven.tolist())) == len(set(body.joints)) == JOINTS
        and all(map(_NAME.fullmatch, body.joints))
        and (np.abs(tree.turn) == 1).all()
        and all(0 <= n < count for part in (tree.foot, tree.soles, tree.driven) for n in part.tolist())
        and (np.concatenate([tree.mass, tree.inertia]) > _LEAST).all()
        and (np.concatenate([tree.radius, tree.stiffness, tree.yielding]) > 0).all()
        and (tree.damping >= 0).all()
        and tree.friction >= 0
        and all(np.isfinite(x).all() for x in (*per_body, *per_ball, *per_joint, body.qpos, body.qvel))
        and all(np.isfinite(x).all() for x in (tree.anchor, tree.centre, tree.ball, tree.imu, body.touch))
        and all(map(math.isfinite, (tree.gravity, tree.friction)))
        and body.stance in (0, 1)
        and _TICKS[0] < tree.timestep < _TICKS[1]
    )
    if not fits:
        raise ValueError
