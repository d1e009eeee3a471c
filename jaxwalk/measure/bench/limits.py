"""What the machine can do at best: C MuJoCo on the same bodies, a product of matrices, a copy of memory."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from jax.sharding import Mesh
from mujoco import rollout

from jaxwalk.config import REFERENCE_HEIGHT, REFERENCE_MASS, Config
from jaxwalk.control.walker import Walker
from jaxwalk.measure.bench.programs import split
from jaxwalk.model import c_mujoco, physics

C_LIMITED, C_CONVERGED = "c_mujoco", "c_mujoco_converged"
BODIES = 128  # for C, whose speed does not depend on how many there are
PRODUCTS, COPIES = 4, 4  # a call
_STATE = int(mujoco.mjtState.mjSTATE_FULLPHYSICS)


class Rollouts:
    """C MuJoCo's own ``rollout`` of the ticks of `programs.bare_steps`.

    Args:
      bodies: walkers in mid-step; the first `BODIES` of them are simulated, each with its own model.
      commands: [B, T, 6] that they follow.
      threads: of the CPU.
      converged: whether the solver runs on, instead of as many iterations as MJX makes.
    """

    def __init__(self, config: Config, bodies: Walker, commands: Any, threads: int, converged: bool) -> None:
        bodies, commands = jax.tree.map(lambda x: x[:BODIES], (bodies, commands))
        settings = c_mujoco.converged(config.physics) if converged else config.physics
        ratio = jax.device_get(bodies.person.ratio)
        self.models = [
            physics.compile_mujoco(
                dataclasses.replace(
                    config.body,
                    height=float(length) * REFERENCE_HEIGHT,
                    mass=float(mass) * REFERENCE_MASS,
                ),
                settings,
            )
            for length, mass in zip(ratio.length, ratio.mass, strict=True)
        ]
        self.data = [mujoco.MjData(self.models[0]) for _ in range(threads)]
        control = jax.vmap(jax.vmap(physics.layout(config.body).control))(commands)
        self.control = np.asarray(control, np.float64)
        plant = jax.tree.map(lambda x: np.asarray(x, np.float64), bodies.plant)
        self.warmstart = plant.warmstart
        self.state = np.zeros((len(self.models), mujoco.mj_stateSize(self.models[0], _STATE)))
        for row, state in enumerate(self.state):
            self.data[0].qpos, self.data[0].qvel = plant.qpos[row], plant.qvel[row]
            mujoco.mj_getState(self.models[row], self.data[0], state, _STATE)

    @property
    def steps(self) -> int:
        """Physics steps that one call makes, of all walkers."""
        return self.control.shape[0] * self.control.shape[1]

    def run(self) -> np.ndarray:
        """Make one call; gives the states, [B, T, S]."""
        states, _ = rollout.rollout(
            self.models, self.data, self.state, self.control, initial_warmstart=self.warmstart,
            persistent_pool=True,
        )  # fmt: skip
        return np.asarray(states)


def product(mesh: Mesh) -> tuple[Callable[[], Any], float]:
    """One call multiplies matrices on every device; and its floating-point operations on each."""
    size = 1024 if _is_cpu() else 8192
    left = split(jnp.ones((mesh.size, size, size)) / size, mesh)

    def multiply(x: jax.Array) -> jax.Array:
        return jax.lax.fori_loop(0, PRODUCTS, lambda _, y: x @ y, x)

    program = _on_each(multiply, mesh).lower(left).compile()
    return lambda: jax.block_until_ready(program(left)), 2.0 * PRODUCTS * size**3


def copy(mesh: Mesh) -> tuple[Callable[[], Any], float]:
    """One call reads and writes an array that fits no cache on every device; and the bytes on each."""
    size = 2**24 if _is_cpu() else 2**28
    array = split(jnp.ones((mesh.size, size)), mesh)

    def add(x: jax.Array) -> jax.Array:
        return jax.lax.fori_loop(0, COPIES, lambda _, y: y + 1.0, x)

    program = _on_each(add, mesh).lower(array).compile()
    return lambda: jax.block_until_ready(program(array)), 2.0 * COPIES * 4 * size


def _is_cpu() -> bool:
    return jax.default_backend() == "cpu"


def _on_each(function: Callable[[jax.Array], jax.Array], mesh: Mesh) -> Any:
    rows = jax.sharding.PartitionSpec(*mesh.axis_names)
    mapped = jax.shard_map(
        lambda x: function(x[0])[None], mesh=mesh, in_specs=rows, out_specs=rows, check_vma=False
    )
    return jax.jit(mapped)
