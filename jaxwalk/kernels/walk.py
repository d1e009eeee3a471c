"""A function of one walker, many times over, as native code: `jax.lax.scan` without a loop of XLA's."""

from __future__ import annotations

import contextlib
import hashlib
import json
import re
import sys
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from functools import cache, lru_cache
from importlib import metadata
from itertools import chain
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp

from jaxwalk.kernels import native, store
from jaxwalk.kernels.entries import Entries, inputs, words
from jaxwalk.kernels.graph import ARITHMETIC, Graph, Unsupported, is_key, reach
from jaxwalk.kernels.settings import jax_setting
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
    program = program_of(function, setting, tree, like)
    given = [_plain(x) for x in leaves]
    results = [given[i] for i in program.changed]
    rows = [jax.ShapeDtypeStruct((length, *x.shape), x.dtype) for x in program.row]
    done = native.call(
        native.target(program.texts),
        given,
        [*(jax.ShapeDtypeStruct(x.shape, x.dtype) for x in results), *rows],
        {i: k for k, i in enumerate(program.changed)},
        length,
        program.flops,
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


@dataclass(frozen=True)
class Program:
    """What a function compiles to.

    Attributes:
      state: how many arrays its state has. changed: which of them it changes.
      row, row_tree: what it writes at each tick, shapes and types, and the tree that they make.
      flops: of one tick.
      texts: its C++.
    """

    state: int
    changed: tuple[int, ...]
    row: tuple[jax.ShapeDtypeStruct, ...]
    row_tree: Any
    flops: int
    texts: tuple[str, ...]


def _unrolled(function: Callable[..., Any], setting: Hashable, tree: Any, like: Any) -> Program:
    graph = Graph()
    given = inputs(graph, [jax.ShapeDtypeStruct(*x) for x in like])
    state, constants = jax.tree.unflatten(tree, given)
    after, row = unrolled(graph, lambda state, *rest: function(setting, state, *rest), state, *constants)
    olds, news = jax.tree.leaves(state), jax.tree.leaves(after)
    if [_form(x) for x in olds] != [_form(x) for x in news]:
        raise Unsupported("a state that does not keep its form")
    rows, row_tree = jax.tree.flatten(row)
    if not all(x.size for x in rows):
        raise Unsupported("an empty row")
    changed = [
        i
        for i, (old, new) in enumerate(zip(olds, news, strict=True))
        if any(a is not b for a, b in zip(old.flat, new.flat, strict=True))
    ]
    plan = native.Plan(
        given=[words(graph, x) for x in given],
        state=[(i, words(graph, news[i])) for i in changed],
        rows=[words(graph, x) for x in rows],
    )
    forms = tuple(jax.ShapeDtypeStruct(*_form(x)) for x in rows)
    computed = reach([x for _, entries in plan.state for x in entries] + [*chain(*plan.rows)])
    flops = sum(node.op in ARITHMETIC and node.dtype.kind == "f" for node in computed)
    return Program(len(olds), tuple(changed), forms, row_tree, flops, native.sources(plan))


def _form(x: Entries) -> tuple[Any, Any]:
    return x.shape, x.flat[0].dtype


def program_of(function: Callable[..., Any], setting: Hashable, tree: Any, like: tuple[Any, ...]) -> Program:
    """What ``function`` compiles to, made once.

    Args:
      tree, like: of its arguments, the form, and shape and type of each.
    """
    settings = jax_setting("jax_enable_x64"), jax_setting("jax_threefry_partitionable")
    return _program_of(function, setting, tree, like, *settings)


@lru_cache(maxsize=32)
def _program_of(
    function: Callable[..., Any], setting: Hashable, tree: Any, like: tuple[Any, ...], *settings: bool
) -> Program:
    """To trace and to unroll takes seconds: a function's C++ is kept from run to run, if its name tells what
    it is and it writes no rows."""
    told = f"{function.__module__} {function.__qualname__} {setting!r} {tree} {like} {settings}"
    origins = _origins(function)
    if origins is None or " at 0x" in told:  # what is different in every process
        return _unrolled(function, setting, tree, like)
    name = f"{hashlib.sha256(f'{told} {origins}'.encode()).hexdigest()}.json"
    if (found := store.recall(name)) is not None:
        with contextlib.suppress(ValueError, TypeError):  # of another form
            state, changed, flops, texts = json.loads(found)
            return Program(state, tuple(changed), (), jax.tree.structure(None), flops, tuple(texts))
    made = _unrolled(function, setting, tree, like)
    if made.row_tree == jax.tree.structure(None):
        content = json.dumps([made.state, made.changed, made.flops, made.texts]).encode()
        with contextlib.suppress(OSError):
            store.kept(name, lambda: content, lambda file: file)
    return made


def _origins(function: Callable[..., Any]) -> str | None:
    """What decides what ``function`` does: the files of its package and of this one, and the versions of what
    its package requires; None if its name does not tell that."""
    package = function.__module__.partition(".")[0]
    module, home = sys.modules.get(function.__module__), sys.modules.get(package)
    if getattr(module, function.__qualname__, None) is not function or not getattr(home, "__path__", None):
        return None
    if getattr(home, "__file__", None) is None:
        return None
    return " ".join(
        _digest(Path(str(sys.modules[name].__file__)).parent) for name in (package, str(__package__))
    ) + _versions(package)


@cache
def _digest(folder: Path) -> str:
    digest = hashlib.sha256()
    for file in sorted(folder.rglob("*")):
        if file.suffix in (".py", ".h"):
            digest.update(f"{file.relative_to(folder)}\0".encode() + file.read_bytes())
    return digest.hexdigest()


@cache
def _versions(package: str) -> str:
    versions = [f"jax {jax.__version__}"]
    with contextlib.suppress(metadata.PackageNotFoundError):
        for line in metadata.requires(package) or ():
            name = re.split(r"[^\w.-]", line)[0]
            with contextlib.suppress(metadata.PackageNotFoundError):
                versions.append(f"{name} {metadata.version(name)}")
    return " ".join(versions)
