"""Functions of one walker that become kernels once they are mapped over walkers."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from functools import lru_cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from jaxwalk.config import BodyConfig, PhysicsConfig
from jaxwalk.kernels import pallas
from jaxwalk.kernels.graph import Graph
from jaxwalk.kernels.unroll import inputs, unrolled
from jaxwalk.newton import WRITTEN_OUT


def usable(body: BodyConfig, physics: PhysicsConfig) -> bool:
    """Whether this process's devices run kernels, and the plant can be unrolled into a few of them.

    Between walls a body has twice the joints and four times the contacts.
    """
    return (
        jax.default_backend() in ("gpu", "cuda")
        and body.model == "planar"
        and physics.iterations <= WRITTEN_OUT
    )


def fused(function: Callable[..., Any], setting: Hashable, *args: Any) -> Any:
    """``function(setting, *args)`` of one walker; under `jax.vmap`, of all of them by kernels.

    Args:
      args: trees of arrays. Random keys may be handed on, but not used.

    Raises:
      Unsupported: ``function`` does what cannot be unrolled.
    """

    @jax.custom_batching.custom_vmap
    def one(*args: Any) -> Any:
        return function(setting, *args)

    @one.def_vmap
    def _(size: int, batched: Any, *args: Any) -> tuple[Any, Any]:
        def many(x: Any, has: bool) -> Any:
            return x if has else jnp.broadcast_to(x, (size, *jnp.shape(x)))

        done = _together(function, setting, size, jax.tree.map(many, args, tuple(batched)))
        return done, jax.tree.map(lambda _: True, done)

    return one(*jax.tree.map(jnp.asarray, args))


def _together(function: Callable[..., Any], setting: Hashable, size: int, args: Any) -> Any:
    """``function`` of ``size`` walkers; ``args`` have them along their leading axis."""
    leaves, tree = jax.tree.flatten(args)
    program = _program(function, setting, tree, tuple((x.shape[1:], x.dtype) for x in leaves))
    done = iter(program.run([leaves[i].reshape(size, -1).T for i in program.read]))
    results = [
        next(done).T.reshape(size, *shape) if same is None else leaves[same]
        for same, shape in zip(program.same, program.shapes, strict=True)
    ]
    return jax.tree.unflatten(program.tree, results)


class _Program:
    """The kernels of a function.

    Attributes:
      read: which of its arguments they are given. run: them, [n, B] each, to the results that are new.
      same: of each result, the argument that it is, if it is one; keys all are.
      shapes: of the results of one walker. tree: that they make.
    """

    def __init__(self, function: Callable[..., Any], setting: Hashable, tree: Any, leaves: Any) -> None:
        graph = Graph()
        given = inputs(graph, [jax.ShapeDtypeStruct(shape, dtype) for shape, dtype in leaves])
        done = unrolled(graph, lambda *x: function(setting, *x), *jax.tree.unflatten(tree, given))
        results, self.tree = jax.tree.flatten(done)
        arguments = {_entries(x): i for i, x in enumerate(given)}
        self.same = [arguments.get(_entries(x)) for x in results]
        self.shapes = [x.shape for x in results]
        self.read = [
            i for i, (_, dtype) in enumerate(leaves) if not jnp.issubdtype(dtype, jax.dtypes.prng_key)
        ]
        new = [i for i, same in enumerate(self.same) if same is None]
        self.run = pallas.kernels(
            [[*given[i].flat] for i in self.read], [[*results[i].flat] for i in new], self._reused(tree, new)
        )

    def _reused(self, tree: Any, new: list[int]) -> dict[int, int]:
        """Of a state that goes on, each new part takes the old one's place: loops copy nothing then."""
        first = jax.tree.structure(jax.tree.unflatten(tree, range(tree.num_leaves))[0])
        return {k: self.read.index(i) for k, i in enumerate(new)} if first == self.tree else {}


def _entries(x: np.ndarray) -> tuple[Any, ...]:
    return (x.shape, *map(id, x.flat))


@lru_cache(maxsize=16)
def _program(function: Callable[..., Any], setting: Hashable, tree: Any, leaves: Any) -> _Program:
    # What is constant is computed by a processor: a GPU would have to compile each small step of it.
    with jax.default_device(jax.local_devices(backend="cpu")[0]):
        return _Program(function, setting, tree, leaves)
