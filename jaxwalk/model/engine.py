"""What moves the plants of a program: MJX's data under our own solver, kernels on a GPU, C MuJoCo or ODE."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import jax
from jaxtyping import Array, Float
from mujoco import mjx

from jaxwalk.common.errors import UserError
from jaxwalk.config import BodyConfig, Config, Engine, Kernels, PhysicsConfig, SensorConfig
from jaxwalk.kernels import fused as kernels
from jaxwalk.model import burdens, c_mujoco, ode, physics
from jaxwalk.model.burdens import Burden
from jaxwalk.model.similarity import Similarity
from jaxwalk.model.solver.newton import WRITTEN_OUT

VARIABLE = "JAXWALK_KERNELS"
"""Environment variable: ``off`` switches kernels off, whatever is configured."""

Model = mjx.Model | None
"""What an engine needs to know of a body: all of it (MJX); C MuJoCo, ODE and kernels make their own."""

_METHODS: dict[Engine, ode.Method] = {"ode": "world", "ode-quick": "quick"}


@dataclass(frozen=True)
class Setup:
    """What all walkers of a program share; hashable, so it is static under jit."""

    body: BodyConfig
    physics: PhysicsConfig
    sensors: SensorConfig
    window_ticks: int
    engine: Engine = "mjx"
    kernels: Kernels = "auto"

    @classmethod
    def of(cls, config: Config, engine: Engine = "mjx") -> Setup:
        """The setup of a configuration, in which the environment can switch kernels off.

        Raises:
          UserError: the environment says neither auto nor off; or ODE is asked for and not here, or cannot
            move such a body.
        """
        if engine in _METHODS:
            ode.check(config.body)
        told = os.environ.get(VARIABLE) or "auto"
        if told not in ("auto", "off"):
            raise UserError(f"{VARIABLE}={told!r:.40}: give auto or off")
        ticks, kernels = config.train.window_ticks, config.kernels if told == "auto" else "off"
        return cls(config.body, config.physics, config.sensors, ticks, engine, kernels)

    @property
    def timestep(self) -> float:
        """Length of one tick, s."""
        return self.physics.timestep


def model(setup: Setup, ratio: Similarity, burden: Burden | None) -> Model:
    """The body of one walker, for ``setup``'s engine."""
    return None if setup.engine != "mjx" else _body(setup, ratio, burden)


def _body(setup: Setup, ratio: Similarity, burden: Burden | None) -> mjx.Model:
    unladen = physics.model_of(setup.body, setup.physics, ratio)
    return unladen if burden is None else burdens.onto(unladen, burden)


def on_gpu(setup: Setup) -> bool:
    """Whether JAX's first choice of devices here is a GPU, and the plant one that unrolls into a few kernels.

    Between walls a body has twice the joints and four times the contacts, which would be too many; more of
    the solver's iterations are a loop, which cannot be unrolled. Of GPUs only NVIDIA's have been tried.
    """
    return jax.default_backend() == "gpu" and setup.body.model == "planar" and unrolls(setup)


def unrolls(setup: Setup) -> bool:
    """Whether kernels may be made of the tick, and can."""
    own = setup.physics.solver == "own" and setup.physics.iterations <= WRITTEN_OUT
    return own and setup.kernels == "auto" and setup.engine == "mjx"


def move(
    setup: Setup,
    model: Model,
    ratio: Similarity,
    burden: Burden | None,
    plant: physics.Plant,
    control: Float[Array, "A"],
    push: Float[Array, "7 2"],
) -> tuple[physics.Plant, physics.Readings]:
    """One tick of the plant alone, by ``setup``'s engine (see `physics.step`).

    Args:
      model: `model` of ``ratio`` and ``burden``, and no other.
    """
    if setup.engine == "mujoco":
        return c_mujoco.step(setup.body, setup.physics, ratio, plant, control, push, burden)
    if setup.engine in _METHODS:
        method = _METHODS[setup.engine]
        return ode.step(setup.body, setup.physics, method, ratio, plant, control, push, burden)
    if on_gpu(setup):
        return kernels.fused(_move, setup, ratio, burden, plant, control, push)
    return physics.step(setup.body, setup.physics, model, plant, control, push)


def _move(setup: Setup, ratio: Similarity, burden: Burden | None, *moving: Any) -> Any:
    model = _body(setup, ratio, burden)
    return physics.step(setup.body, setup.physics, model, *moving)
