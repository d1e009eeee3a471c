"""A function of one walker, many times over, as native code: `jax.lax.scan` without a loop of XLA's."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from functools import lru_cache
from typing import Any

import jax
import jax.numpy as jnp

from jaxwalk.kernels import native
from jaxwalk.kernels.entries import Entries, inputs
from jaxwalk.kernels.graph import Entry, Graph, Unsupported, is_key
from jaxwalk.kernels.unroll import unrolled


def scan(
    function: Callable[..., Any], setting: Hashable, length: int, state: Any, *constants: Any
) -> tuple[Any, Any]:
    """``jax.lax.scan(lambda state, _: function(setting, state, *constants), state, length=length)``, without
    gradients; under `jax.vmap`, of all walkers at once.

    Args:
      function: of the module's level, for what it compiles to is kept; gives the new state and a row.
      state, constants: trees of arrays, none of them empty.

    Raises:
      Unsupported: ``function`` does what cannot be unrolled.
      compiler.BuildError: it cannot be compiled here.
    """
    leaves, tree = jax.tree.flatten(jax.tree.map(jnp.asarray, (state, constants)))
    like = tuple((x.shape, x.dtype) for x in leaves)
    program = program_of(function, setting, tree, like, bool(jax.config.jax_enable_x64))
    given = [_plain(x) for x in leaves]
    results = [given[i] for i in program.changed]
    rows = [jax.ShapeDtypeStruct((length, *x.shape), x.dtype) for x in program.row]
    done = native.call(
        program.target(),
        given,
        [*(jax.ShapeDtypeStruct(x.shape, x.dtype) for x in results), *rows],
        {i: k for k, i in enumerate(program.changed)},
        length,
    )
    news = iter(done)
    after = list(leaves[: program.state])
    for i in program.changed:
        new = next(news)
        after[i] = jax.random.wrap_key_data(new) if is_key(leaves[i].dtype) else new
    walked = jax.tree.unflatten(jax.tree.structure(state), after)
    return walked, jax.tree.unflatten(program.row_tree, list(news))


def _plain(x: jax.Array) -> jax.Array:
    return jax.random.key_data(x) if is_key(x.dtype) else x


class Program:
    """What a function compiles to.

    Attributes:
      changed: which arrays of the state, of which there are ``state``, it changes.
      row, row_tree: what it writes at each tick, shapes and types, and the tree that they make.
      plan: its arithmetic.
    """

    def __init__(self, function: Callable[..., Any], setting: Hashable, tree: Any, like: Any) -> None:
        graph = Graph()
        given = inputs(graph, [jax.ShapeDtypeStruct(*x) for x in like])
        state, constants = jax.tree.unflatten(tree, given)
        after, row = unrolled(graph, lambda state, *rest: function(setting, state, *rest), state, *constants)
        self.state = len(jax.tree.leaves(state))
        olds, news = jax.tree.leaves(state), jax.tree.leaves(after)
        if [_form(x) for x in olds] != [_form(x) for x in news]:
            raise Unsupported("a state that does not keep its form")
        rows, self.row_tree = jax.tree.flatten(row)
        self.row = [jax.ShapeDtypeStruct(*_form(x)) for x in rows]
        self.changed = [
            i
            for i, (old, new) in enumerate(zip(olds, news, strict=True))
            if any(a is not b for a, b in zip(old.flat, new.flat, strict=True))
        ]
        self.plan = native.Plan(
            given=[_words(graph, x) for x in given],
            state=[(i, _words(graph, news[i])) for i in self.changed],
            rows=[_words(graph, x) for x in rows],
        )

    def target(self) -> str:
        """The name under which XLA calls it."""
        return native.target(native.source(self.plan))


def _form(x: Entries) -> tuple[Any, Any]:
    return x.shape, x.flat[0].dtype


def _words(graph: Graph, x: Entries) -> list[Entry]:
    """The numbers of ``x``; of keys, their words."""
    entries = [*x.flat]
    return [w for one in entries for w in graph.words(one)] if is_key(x.flat[0].dtype) else entries


@lru_cache(maxsize=32)
def program_of(
    function: Callable[..., Any], setting: Hashable, tree: Any, like: tuple[Any, ...], x64: bool
) -> Program:
    """What ``function`` compiles to, made once."""
    return Program(function, setting, tree, like)
