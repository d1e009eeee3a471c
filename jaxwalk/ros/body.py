"""The file that the nodes know the walker by: its body for ODE, and where it starts."""

from __future__ import annotations

import dataclasses
import json
import os
from dataclasses import dataclass
from typing import Any

import numpy as np

from jaxwalk.common import untrusted
from jaxwalk.common.errors import UserError
from jaxwalk.ode import Tree

_CURE = "give the body.json that jaxwalk ros writes"
_WHOLE = ("parent", "foot", "soles", "driven")  # numbers of bodies
_SINGLE = ("timestep", "gravity", "friction")


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
    per_body = tree.mass, tree.inertia, tree.turn, tree.damping, tree.anchor[:, 0], tree.centre[:, 1]
    per_ball = tree.ball[:, 1], tree.radius, tree.stiffness, tree.yielding
    per_joint = tree.gain, tree.offset, tree.rate, tree.limit
    fits = (
        all(len(x) == count for x in (tree.parent, *per_body))
        and all(len(x) == len(tree.foot) for x in per_ball)
        and all(len(x) == len(tree.driven) == len(body.joints) for x in per_joint)
        and len(body.qpos) == len(body.qvel) == count + 2
        and (tree.parent < np.arange(count)).all()
        and all(0 <= n < count for part in (tree.foot, tree.soles, tree.driven) for n in part.tolist())
        and (np.concatenate([tree.mass, tree.inertia, tree.radius, tree.stiffness, tree.yielding]) > 0).all()
        and all(np.isfinite(x).all() for x in (*per_body, *per_ball, *per_joint, body.qpos, body.qvel))
        and body.stance in (0, 1)
        and body.touch.shape == (2,)
        and tree.timestep > 0
    )
    if not fits:
        raise ValueError
