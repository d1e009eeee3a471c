"""A JAX function of small arrays, unrolled into arithmetic on single numbers.

Gathers, transposes and the like move entries and cost nothing; structural zeros vanish with all that they
would have been multiplied with. What is left of a step of multibody dynamics is the arithmetic that somebody
would have written down by hand for this one mechanism, as code generators for robots do (Carpentier et al.
2019, "The Pinocchio C++ library").
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, cast

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import ShapedArray
from jax.extend import core as jex

from jaxwalk.kernels.entries import Entries, constant, numbers
from jaxwalk.kernels.graph import Graph, Unsupported, known
from jaxwalk.kernels.rules import RULES

_CALLS = ("jit", "pjit", "custom_jvp_call", "custom_vmap_call", "closed_call")


def unrolled(graph: Graph, function: Callable[..., Any], *args: Any) -> Any:
    """``function`` of trees of entries; it is traced for their shapes and types.

    Args:
      args: trees of arrays of entries, by `entries.inputs` or `entries.constant`, none of them empty.

    Returns:
      Its results, a tree of arrays of entries.

    Raises:
      Unsupported: it does what cannot be unrolled, or there is an empty array among its arguments.
    """
    leaves, tree = jax.tree.flatten(args)
    if not all(x.size for x in leaves):
        raise Unsupported("an empty array")
    like = [jax.ShapeDtypeStruct(x.shape, x.flat[0].dtype) for x in leaves]
    traced = jax.make_jaxpr(lambda *x: function(*jax.tree.unflatten(tree, x)), return_shape=True)
    closed, shape = traced(*like)
    return jax.tree.unflatten(jax.tree.structure(shape), _run(graph, closed, leaves))


def _run(graph: Graph, closed: jex.ClosedJaxpr, args: Sequence[Entries]) -> list[Entries]:
    """The results of ``closed`` for ``args``."""
    jaxpr = closed.jaxpr
    known_as: dict[Any, Entries] = dict(zip(jaxpr.constvars, map(constant, closed.consts), strict=True))
    known_as.update(zip(jaxpr.invars, args, strict=True))

    for eqn in _needed(jaxpr):
        results = _bind(graph, eqn, [_read(known_as, x) for x in eqn.invars])
        known_as.update(zip(eqn.outvars, results, strict=True))
    return [_read(known_as, x) for x in jaxpr.outvars]


def _read(known_as: dict[Any, Entries], atom: Any) -> Entries:
    if isinstance(atom, jex.Literal):
        return constant(np.asarray(atom.val, cast(ShapedArray, atom.aval).dtype))
    return known_as[atom]


def _bind(graph: Graph, eqn: Any, args: list[Entries]) -> list[Entries]:
    """The results of one equation."""
    name, params = eqn.primitive.name, eqn.params
    if name in _CALLS:
        inner = next(params[k] for k in ("jaxpr", "call_jaxpr", "call") if k in params)
        return _run(graph, inner if hasattr(inner, "jaxpr") else jex.ClosedJaxpr(inner, ()), args)
    if name in RULES:
        results = RULES[name](graph, params, eqn.outvars[0].aval, *args)
        return results if isinstance(results, list) else [results]
    if all(all(map(known, x.flat)) for x in args):
        return _evaluated(eqn, args)
    raise Unsupported(f"{name} of what is not constant")


def _needed(jaxpr: Any) -> list[Any]:
    """The equations of ``jaxpr``, without those whose results nobody reads."""
    wanted = {x for x in jaxpr.outvars if not isinstance(x, jex.Literal)}
    kept = []
    for eqn in reversed(jaxpr.eqns):
        if any(x in wanted for x in eqn.outvars):
            kept.append(eqn)
            wanted |= {x for x in eqn.invars if not isinstance(x, jex.Literal)}
    return kept[::-1]


def _evaluated(eqn: Any, args: list[Entries]) -> list[Entries]:
    """An equation of constants, by JAX itself."""
    with jax.ensure_compile_time_eval():
        told = [jnp.asarray(numbers(x, v.aval.dtype)) for x, v in zip(args, eqn.invars, strict=True)]
        results = eqn.primitive.bind(*told, **eqn.params)
    return [constant(x) for x in (results if eqn.primitive.multiple_results else [results])]
