"""Whom a command is about: POLICY on the command line, made into a configuration and a policy."""

from __future__ import annotations

import dataclasses
import hashlib
import math
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jax
import numpy as np
from jaxtyping import Array, Float

from jaxwalk.common import resources, untrusted
from jaxwalk.common.errors import UserError
from jaxwalk.config import REFERENCE_HEIGHT, Actuators, BodyModel, Config, of_dict, validate
from jaxwalk.learn.policies import policy
from jaxwalk.learn.runs import run_folder
from jaxwalk.options import checks
from jaxwalk.task import collect, rules

SHIPPED, FIXED = "shipped", "fixed"


@dataclass(frozen=True)
class Subject:
    """A policy with the configuration that it acts under.

    Attributes:
      name: as it was asked for.
      config: of its training run, with the changes asked for.
      params: pytree handed to ``act``.
      act: (params, raw observation [O]) -> action [2] in [-1, 1]; pure.
    """

    name: str
    config: Config
    params: Any
    act: Callable[[Any, Float[Array, "O"]], Float[Array, "2"]]

    @property
    def digest(self) -> str:
        """SHA-256 of the parameters: two subjects of one digest and configuration act alike."""
        hashed = hashlib.sha256()
        for leaf in jax.tree.leaves(self.params):
            hashed.update(np.asarray(leaf).tobytes())
        return hashed.hexdigest()


def load(
    name: str,
    *,
    speed: float | None = None,
    height: float | None = None,
    mass: float | None = None,
    noise: float | None = None,
    model: BodyModel | None = None,
    actuators: Actuators | None = None,
) -> Subject:
    """The subject called ``name``: a run folder, a policy file, or a name of `checks.BUILT_IN`.

    Args:
      speed: desired, m/s. height: m. mass: kg. noise: scale of the sensors' noise. model: of the
        body. actuators: whose strength the joints have. None leaves the value of the policy's own
        configuration.

    Raises:
      UserError: no such policy, a damaged one, or a value out of range.
    """
    changes = speed, height, mass, noise, model, actuators
    if name == FIXED:
        config = _changed(rules.configured(Config(), rules.Constant()), *changes)
        return Subject(name, config, rules.nominal(config), rules.never_adapted)
    if name in rules.RULES:
        config = _changed(rules.configured(Config(), rules.RULES[name]), *changes)
        rule = rules.strong(rules.RULES[name])
        return Subject(name, config, (rule, rules.reference(config.gait)), rules.act)
    path = file(name)
    loaded = policy.load(path)
    trained = configured(path, loaded)
    gait, told = trained.gait, loaded.metadata
    if (told.observation_names, told.action_low, told.action_high) != (trained.observation, *gait.answers):
        raise UserError(
            f"policy {path}: it contradicts its own configuration; give a policy that jaxwalk saved"
        )
    config = _changed(trained, *changes)
    return Subject(name, config, policy.without_origin(loaded), policy.act)


def asked(options: Any) -> Subject:
    """As `load`, what a command's options of these names ask for.

    Raises:
      UserError: as there.
    """
    told = {
        name: getattr(options, name) for name in ("speed", "height", "mass", "noise", "model", "actuators")
    }
    return load(options.policy, **told)


def configured(path: Path, loaded: policy.Policy) -> Config:
    """The configuration of the run that ``loaded`` comes from, the file ``path``.

    Raises:
      UserError: it is not one that this version can run.
    """
    try:
        trained = of_dict(untrusted.parse(loaded.metadata.config))
        return _changed(trained)
    except (UserError, untrusted.Bad, ArithmeticError) as error:
        raise UserError(f"policy {path}: its configuration does not fit this version ({error})") from None


def trained(name: str) -> tuple[policy.Policy, Config]:
    """The trained policy called ``name``, and the configuration of its run.

    Raises:
      UserError: a rule that nobody trained, no such policy, or a damaged one.
    """
    subject = load(name)  # which sees that it fits its configuration
    if origin(name) is None:
        raise UserError(
            f"policy {name!r} is a rule, not trained: give a run folder, a policy file or shipped"
        )
    return policy.load(file(name)), subject.config


def origin(name: str) -> policy.Metadata | None:
    """Where the policy called ``name`` comes from; None for the rules that nobody trained.

    Raises:
      UserError: no such policy, or a damaged one.
    """
    return None if name == FIXED or name in rules.RULES else policy.load(file(name)).metadata


def file(name: str) -> Path:
    """Where the trained policy called ``name`` lies."""
    if name in checks.TRAINED:
        return resources.model_path(f"{name}.safetensors")
    path = Path(name)
    return path / run_folder.POLICY if os.path.isdir(path) else path


def _changed(
    config: Config,
    speed: float | None = None,
    height: float | None = None,
    mass: float | None = None,
    noise: float | None = None,
    model: BodyModel | None = None,
    actuators: Actuators | None = None,
) -> Config:
    body = dataclasses.replace(
        config.body,
        height=config.body.height if height is None else height,
        mass=config.body.mass if mass is None else mass,
        model=config.body.model if model is None else model,
    )
    gait = config.gait if speed is None else dataclasses.replace(config.gait, speed_desired=speed)
    sensors = config.sensors if noise is None else dataclasses.replace(config.sensors, noise=noise)
    physics = config.physics
    if actuators is not None:
        physics = dataclasses.replace(physics, actuators=actuators)
    changed = dataclasses.replace(config, body=body, gait=gait, sensors=sensors, physics=physics)
    validate.check(changed)
    seconds = changed.train.window_ticks * changed.physics.timestep
    share = body.height / REFERENCE_HEIGHT
    if seconds > (toe_off := collect.shortest_toe_off(changed.gait, share)):
        least = share * (seconds / toe_off) ** 2 * REFERENCE_HEIGHT
        raise UserError(
            f"--height {body.height:g}: the toe-off of so short a walker ({toe_off:.3f} s) ends before the "
            f"policy is asked ({seconds:.3f} s): give at least {math.ceil(least * 100) / 100:g} m"
        )
    return changed
