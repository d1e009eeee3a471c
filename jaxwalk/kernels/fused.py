"""Functions of one walker that become kernels once they are mapped over walkers."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Hashable
from functools import lru_cache
from typing import Any

import jax
import jax.numpy as jnp

from jaxwalk.kernels import pallas
from jaxwalk.kernels.entries import Entries, inputs
from jaxwalk.kernels.graph import Graph, Unsupported, is_key, reach
from jaxwalk.kernels.settings import jax_setting
from jaxwalk.kernels.unroll import unrolled


def fused(function: Callable[..., Any], setting: Hashable, *args: Any) -> Any:
    """``function(setting, *args)`` of one walker; under `jax.vmap`, of all of them by kernels.

    It has no gradient, and under `jax.shard_map` needs ``check_vma=False``.

    Args:
      function: of the module's level: its kernels are kept for as long as it is.
      args: trees of arrays, none of them empty. Random keys may be handed on, but not used.

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
    told = tuple((x.shape[1:], x.dtype) for x in leaves)
    program = program_of(function, setting, tree, told, jax_setting("jax_enable_x64"))
    done = iter(program.run([leaves[i].reshape(size, -1).T for i in program.read]))
    results = [
        next(done).T.reshape(size, *shape) if same is None else leaves[same]
        for same, shape in zip(program.same, program.shapes, strict=True)
    ]
    return jax.tree.unflatten(program.tree, results)


class Program:
    """The kernels of a function.

    Attributes:
      read: which of its arguments they are given. run: these, [n, B] each, to the results that are new.
      same: of each result, the argument that it is, if it is one; keys all are.
      shapes: of the results of one walker. tree: that they make.
    """

    def __init__(self, function: Callable[..., Any], setting: Hashable, tree: Any, leaves: Any) -> None:
        graph = Graph()
        given = inputs(graph, [jax.ShapeDtypeStruct(shape, dtype) for shape, dtype in leaves])
        done = unrolled(graph, lambda *x: function(setting, *x), *jax.tree.unflatten(tree, given))
        results, self.tree = jax.tree.flatten(done)
        arguments = {_names(x): i for i, x in enumerate(given)}
        self.same = [arguments.get(_names(x)) for x in results]
        self.shapes = [x.shape for x in results]
        self.read = [i for i, (_, dtype) in enumerate(leaves) if not is_key(dtype)]
        new = [i for i, same in enumerate(self.same) if same is None]
        if any(node.op in ("key", "word") for node in reach([x for i in new for x in results[i].flat])):
            raise Unsupported("random keys that are used, not handed on")
        if any(not results[i].size or is_key(results[i].flat[0].dtype) for i in new):
            raise Unsupported("a result that is empty, or a key that is not handed on as it was")
        self.run = pallas.kernels(
            [[*given[i].flat] for i in self.read],
            [[*results[i].flat] for i in new],
            self._reused(tree, given, results, new),
        )

    def _reused(
        self, tree: Any, given: list[Entries], results: list[Entries], new: list[int]
    ) -> dict[int, int]:
        """Which result takes which argument's place: a state that goes on is written over, not copied."""
        first = jax.tree.structure(jax.tree.unflatten(tree, range(tree.num_leaves))[0])
        if first != self.tree:
            return {}
        return {
            k: self.read.index(i)
            for k, i in enumerate(new)
            if given[i].shape == results[i].shape and given[i].flat[0].dtype == results[i].flat[0].dtype
        }


@lru_cache(maxsize=16)
def program_of(
    function: Callable[..., Any], setting: Hashable, tree: Any, leaves: tuple[Any, ...], x64: bool
) -> Program:
    """The kernels of ``function``, made once.

    Args:
      tree, leaves: of its arguments, shape and type of each. x64: as JAX is set.
    """
    with _by_processor():
        return Program(function, setting, tree, leaves)


def _by_processor() -> contextlib.AbstractContextManager[Any]:
    """What is constant is computed by a processor: a GPU would have to compile each small step of it."""
    try:
        return jax.default_device(jax.local_devices(backend="cpu")[0])
    except RuntimeError:  # it has been told to do without
        return contextlib.nullcontext()


def _names(x: Entries) -> tuple[Any, ...]:
    return (x.shape, *map(id, x.flat))
