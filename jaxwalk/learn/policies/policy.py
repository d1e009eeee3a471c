"""A trained policy as one safetensors file: the actor, the observation statistics, its origin.

Reading a file executes nothing in it, and every way in which it can be bad is one ``UserError``.
"""

from __future__ import annotations

import dataclasses
import importlib.metadata
import json
import math
import os
import typing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import safetensors.numpy
from jaxtyping import Array, Float

from jaxwalk.common import files, untrusted, untrusted_arrays
from jaxwalk.common.errors import UserError
from jaxwalk.common.untrusted import Bad
from jaxwalk.config import Config, to_dict
from jaxwalk.deploy.file import MAX_BYTES
from jaxwalk.learn.ddpg import networks, normalizer
from jaxwalk.learn.ddpg.learner import LearnerState
from jaxwalk.task.transition import Leaf

FORMAT_VERSION = 1
_HEADER_KEY = "jaxwalk_policy"
_CURE = "give a policy that jaxwalk saved"


@dataclass(frozen=True)
class Metadata:
    """What the numbers mean and where they come from; plain JSON values throughout.

    Attributes:
      observation_names: O names, in the order of the observation.
      observation_clip: largest normalised observation, standard deviations; None: no limit.
      action_names: A names, in the order of the action.
      action_low, action_high: what actions -1 and 1 stand for on the reference body, m and s: see
        `GaitConfig.answers`.
      hidden: widths of the actor's hidden layers.
      config: the whole configuration of the run, as JSON text (see ``jaxwalk.config.to_dict``).
      seed: of the run.
      command: the command line of the run.
      footsteps: footsteps trained before this policy was taken.
      score: of its evaluation; None: not evaluated.
      jaxwalk_version: that saved it.
      format_version: of the file.
    """

    observation_names: tuple[str, ...]
    observation_clip: float | None
    action_names: tuple[str, ...]
    action_low: tuple[float, ...]
    action_high: tuple[float, ...]
    hidden: tuple[int, ...]
    config: str
    seed: int
    command: str
    footsteps: int
    score: float | None
    jaxwalk_version: str
    format_version: int = FORMAT_VERSION


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Policy:
    """Raw observation [O] to action [A] in [-1, 1].

    Attributes:
      actor: parameters of ``networks.Actor``, a nested dict.
      observation_mean: [O], units of each observable.
      observation_std: [O], the same, above 0.
      metadata: static.
    """

    actor: networks.Params
    observation_mean: Leaf
    observation_std: Leaf
    metadata: Metadata = field(metadata={"static": True})


def act(policy: Policy, observation: Float[Array, "*B O"]) -> Float[Array, "*B A"]:
    """The action in [-1, 1] for raw observations; pure."""
    meta = policy.metadata
    observation = normalizer.standardize(
        observation, policy.observation_mean, policy.observation_std, meta.observation_clip
    )
    actor = networks.Actor(meta.hidden, len(meta.action_names))
    return networks.applied(actor, policy.actor, observation)


def without_origin(policy: Policy) -> Policy:
    """The same policy less what does not change its actions: one program serves all of one shape."""
    plain = dataclasses.replace(
        policy.metadata, config="{}", seed=0, command="", footsteps=0, score=None, jaxwalk_version=""
    )
    return dataclasses.replace(policy, metadata=plain)


def from_learner(
    config: Config, state: LearnerState, *, seed: int, command: str, footsteps: int, score: float | None
) -> Policy:
    """The policy that ``state`` has learned so far under ``config``."""
    seen, told = state.normalizer, len(config.observation)
    return of_parts(
        config, state.actor, seen.mean[:told], seen.std[:told], clip=seen.clip,
        seed=seed, command=command, footsteps=footsteps, score=score,
    )  # fmt: skip


def of_parts(
    config: Config,
    actor: networks.Params,
    mean: Float[Array, "O"],
    std: Float[Array, "O"],
    *,
    clip: float | None,
    seed: int,
    command: str,
    footsteps: int,
    score: float | None,
) -> Policy:
    """The policy of an actor that was trained under ``config``, by whatever learner.

    Args:
      actor: parameters of ``networks.Actor`` with ``config.ddpg.hidden``.
      mean, std: of the observation. clip: of the normalised one.
      score: of its evaluation; one that is not finite is none.
    """
    low, high = config.gait.answers
    metadata = Metadata(
        observation_names=config.observation,
        observation_clip=clip,
        action_names=("length", "duration"),
        action_low=low,
        action_high=high,
        hidden=config.ddpg.hidden,
        config=json.dumps(to_dict(config)),
        seed=seed,
        command=command,
        footsteps=footsteps,
        score=score if score is not None and math.isfinite(score) else None,
        jaxwalk_version=_version(),
    )
    return Policy(actor, mean, std, metadata)


def save(policy: Policy, path: str | os.PathLike[str]) -> None:
    """Write atomically: ``path`` holds the old file or the whole new one, never a part.

    Raises:
      UserError: the file cannot be written there.
      ValueError: a policy that ``load`` would refuse.
    """
    try:
        write(policy, path)
    except OSError as error:
        reason = error.strerror or error
        raise UserError(f"policy {path}: cannot be written ({reason}); choose another place") from None


def write(policy: Policy, path: str | os.PathLike[str]) -> None:
    """As `save`, for a training, which says itself how it goes on.

    Raises:
      OSError: the file cannot be written there.
      ValueError: a policy that ``load`` would refuse.
    """
    numbers = tensors(policy)
    if problem := _problem(policy.metadata, numbers):
        raise ValueError(f"policy not saved: {problem}")
    files.replace(Path(path), safetensors.numpy.save(numbers, header(policy)))


def load(path: str | os.PathLike[str]) -> Policy:
    """Read what ``save`` wrote.

    Raises:
      UserError: no file, no policy, or a policy that is damaged or too large.
    """
    content = untrusted.content(path, MAX_BYTES, _CURE)
    try:
        told, found = untrusted_arrays.safetensors(content)
        if _HEADER_KEY not in told:
            raise Bad("a safetensors file, but not of a jaxwalk policy")
        return _decode(told[_HEADER_KEY], found)
    except Bad as bad:
        raise UserError(untrusted.unreadable(path, bad, _CURE)) from None


def _decode(header: str, tensors: dict[str, np.ndarray]) -> Policy:
    values = untrusted.parse(header)
    version = values.get("format_version") if isinstance(values, dict) else None
    if type(version) is int and version != FORMAT_VERSION:
        raise Bad(f"format {version!r:.20}, but this jaxwalk reads {FORMAT_VERSION}")
    try:
        hints = typing.get_type_hints(Metadata)
        metadata = Metadata(**{name: _plain(values[name], hint) for name, hint in hints.items()})
        untrusted.parse(metadata.config)
    except (Bad, KeyError, TypeError):
        raise Bad("its metadata are damaged") from None
    if problem := _problem(metadata, tensors):
        raise Bad(problem)
    arrays = {name: jnp.asarray(x) for name, x in tensors.items()}
    actor: networks.Params = {}
    for name in _shapes(metadata):
        if name.startswith("actor/"):
            _, layer, leaf = name.split("/")
            actor.setdefault(layer, {})[leaf] = arrays[name]
    return Policy(actor, arrays["observation/mean"], arrays["observation/std"], metadata)


def _plain(value: Any, hint: Any) -> Any:
    """``value`` (from JSON) as the type ``hint``, lists as tuples; TypeError if it is not one."""
    if typing.get_origin(hint) is tuple:
        if not isinstance(value, list):
            raise TypeError
        return tuple(_plain(v, typing.get_args(hint)[0]) for v in value)
    allowed = typing.get_args(hint) or (hint,)
    if float in allowed and type(value) is int:
        value = float(value)
    if type(value) not in allowed or (type(value) is float and not math.isfinite(value)):
        raise TypeError
    return value


def tensors(policy: Policy) -> dict[str, np.ndarray]:
    """The file's tensors by name, as in ``_shapes``."""
    actor = {f"actor/{layer}/{leaf}": x for layer, xs in policy.actor.items() for leaf, x in xs.items()}
    seen = {"observation/mean": policy.observation_mean, "observation/std": policy.observation_std}
    return {name: np.asarray(x) for name, x in (actor | seen).items()}


def header(policy: Policy) -> dict[str, str]:
    """The file's header: the metadata as JSON text."""
    return {_HEADER_KEY: json.dumps(dataclasses.asdict(policy.metadata), allow_nan=False)}


def _shapes(metadata: Metadata) -> dict[str, tuple[int, ...]]:
    """The name and shape of every tensor that the metadata call for."""
    observation, action = len(metadata.observation_names), len(metadata.action_names)
    layers = [*(f"hidden_{i}" for i in range(len(metadata.hidden))), "output"]
    widths = [observation, *metadata.hidden, action]
    shapes: dict[str, tuple[int, ...]] = {
        "observation/mean": (observation,),
        "observation/std": (observation,),
    }
    for layer, inputs, outputs in zip(layers, widths[:-1], widths[1:], strict=True):
        shapes |= {f"actor/{layer}/kernel": (inputs, outputs), f"actor/{layer}/bias": (outputs,)}
    return shapes


def _problem(metadata: Metadata, tensors: dict[str, np.ndarray]) -> str | None:
    """What makes a policy unfit for use, if anything."""
    if not len(metadata.action_low) == len(metadata.action_high) == len(metadata.action_names):
        return "action names and bounds differ in number"
    if not all(low < high for low, high in zip(metadata.action_low, metadata.action_high, strict=True)):
        return "action bounds are not in order"
    shapes = _shapes(metadata)
    if tensors.keys() != shapes.keys():
        return f"tensors {_some(tensors.keys() ^ shapes.keys())} are missing or too many"
    for name, x in tensors.items():
        if x.shape != shapes[name] or x.dtype != np.float32:
            return f"tensor {name} is {x.dtype}{list(x.shape)}, not float32{list(shapes[name])}"
        if not np.isfinite(x).all():
            return f"tensor {name} holds numbers that are not finite"
    return None if (tensors["observation/std"] > 0).all() else "observation/std is not above 0"


def _some(names: set[str]) -> str:
    """At most three names on one line."""
    shown = sorted(names)[:3]
    return ", ".join(f"{name!r:.40}" for name in shown) + (", ..." if len(names) > len(shown) else "")


def _version() -> str:
    try:
        return importlib.metadata.version("jaxwalk")
    except importlib.metadata.PackageNotFoundError:  # run from a source tree
        return "unknown"
