"""The policy: raw observation to action, as `jaxwalk.learn.policies.policy.act` computes it."""

from __future__ import annotations

import os
import typing
from dataclasses import dataclass
from typing import Any

import numpy as np

from jaxwalk.common.errors import UserError
from jaxwalk.config import GaitConfig, Observable, validate
from jaxwalk.config.gait import SWITCHES
from jaxwalk.deploy import file, person

_LONGEST_WINDOW = 10_000  # ticks of the moving mean


@dataclass(frozen=True)
class Policy:
    """Raw observation [O] to action [A] in [-1, 1].

    Attributes:
      manifest: names, units, bounds, and every number of the controllers around it.
      layers: (kernel [in, out], bias [out]) of each, float32.
      mean, std: [O] of the observation. clip: largest normalised one; None: no limit.
      low, high: [A] what actions -1 and 1 stand for on the reference body, m and s: of the step, or of what
        is changed of the step that is planned.
    """

    manifest: dict[str, Any]
    layers: tuple[tuple[np.ndarray, np.ndarray], ...]
    mean: np.ndarray
    std: np.ndarray
    clip: float | None
    low: np.ndarray
    high: np.ndarray

    def act(self, observation: np.ndarray) -> np.ndarray:
        """[..., O] raw observations to [..., A] actions in [-1, 1]."""
        x = (np.asarray(observation, np.float32) - self.mean) / self.std
        if self.clip is not None:
            x = np.clip(x, -self.clip, self.clip)
        *hidden, (kernel, bias) = self.layers
        for weights, offset in hidden:
            x = np.maximum(x @ weights + offset, np.float32(0))
        return np.tanh(x @ kernel + bias)

    def command(self, action: np.ndarray) -> np.ndarray:
        """[..., A] actions to (length m, duration s) on the reference body."""
        return self.low + np.float32(0.5) * (np.clip(action, -1, 1) + np.float32(1)) * (self.high - self.low)


def load(path: str | os.PathLike[str]) -> Policy:
    """The policy of an exported .safetensors or .npz file.

    Raises:
      UserError: no such file, or not one that ``jaxwalk export`` wrote.
    """
    manifest, tensors = file.read(path)
    try:
        policy = _decode(manifest, tensors)
        fits = _fits(policy)
        _check(manifest)
    except (AttributeError, IndexError, KeyError, TypeError, ValueError, ArithmeticError, UserError):
        raise UserError(f"policy {path}: its parts do not fit together; export it anew") from None
    if not fits:
        raise UserError(f"policy {path}: its tensors are damaged; export it anew")
    return policy


def _fits(policy: Policy) -> bool:
    """Whether shapes, types and names go together, and all numbers are finite."""
    sizes = [len(policy.mean), *(bias.shape[0] for _, bias in policy.layers)]
    fits = all(
        kernel.shape == (a, b) and bias.shape == (b,)
        for (kernel, bias), a, b in zip(policy.layers, sizes[:-1], sizes[1:], strict=True)
    )
    layers = [x for layer in policy.layers for x in layer]
    arrays = [policy.low, policy.high, policy.mean, policy.std, *layers]
    sound = all(x.dtype == np.float32 and np.isfinite(x).all() for x in arrays) and (policy.std > 0).all()
    shapes = policy.std.shape == policy.mean.shape == (sizes[0],) and sizes[-1] == len(policy.low)
    return bool(fits and sound and shapes and len(policy.manifest["observation"]) == sizes[0] > 0)


def _check(manifest: dict[str, Any]) -> None:
    """See that the controllers can run on these numbers.

    Raises:
      KeyError, TypeError, ValueError, UserError: they cannot.
    """
    told = manifest["sensors"]
    gain = np.array(told["kalman_gain"], np.float32)
    positive = [manifest["timestep"], manifest["gravity"], *manifest["reference"].values()]
    if (clip := manifest["observation_clip"]) is not None:
        positive.append(clip)
    window = told["mean_window"]
    sound = (
        all(type(x) in (int, float) and x > 0 for x in positive)
        and type(window) is int
        and 0 < window <= _LONGEST_WINDOW
        and gain.shape == (2, 2)
        and {one["name"] for one in manifest["observation"]} <= set(typing.get_args(Observable))
    )
    validate.from_dict(GaitConfig, manifest["switches"])
    who = person.build(manifest)
    parts = who, who.gait, who.gait.compliant, who.gait.step_plan
    own = [x for part in parts for x in vars(part).values() if isinstance(x, np.floating)]
    decisions = manifest.get("decisions", {"replan": 0, "window_ticks": 1})
    counts = (decisions["replan"], decisions["window_ticks"] - 1)
    sound = sound and all(type(x) is int and x >= 0 for x in counts)
    strong = who.strength is None or _is_strength(who.strength)
    legs = who.gait.compliant
    divisors = legs.knee_seconds, legs.push_off_ramp, legs.pitch_nominal, who.gait.step_plan.back_speed
    divisors += legs.swing_soonest, legs.swing_acceleration_most, legs.lag_seconds
    divisors += legs.lag_speed, legs.lag_most  # bounds
    strong = strong and min(divisors) > 0
    sound = sound and set(manifest["switches"]) <= set(SWITCHES)
    if not sound or not strong or not np.isfinite(own).all() or not who.leg > 0:
        raise ValueError


def _is_strength(told: np.ndarray) -> bool:
    """Whether torques fall from their largest on as rates grow."""
    _, three_quarters, half = told.transpose(1, 0, 2)
    sound = np.isfinite(told).all() and (told > 0).all()
    return bool(sound and (half > three_quarters).all() and (half >= 2 * three_quarters - 1e-6).all())


def _decode(manifest: dict[str, Any], tensors: dict[str, np.ndarray]) -> Policy:
    names = [*(f"hidden_{i}" for i in range(len(manifest["hidden"]))), "output"]
    if [one["name"] for one in manifest["action"]] != ["length", "duration"]:
        raise ValueError
    bounds = np.array([[one["low"], one["high"]] for one in manifest["action"]], np.float32)
    return Policy(
        manifest=manifest,
        layers=tuple((tensors[f"actor/{name}/kernel"], tensors[f"actor/{name}/bias"]) for name in names),
        mean=tensors["observation/mean"],
        std=tensors["observation/std"],
        clip=manifest["observation_clip"],
        low=bounds[:, 0],
        high=bounds[:, 1],
    )
