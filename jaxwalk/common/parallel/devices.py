"""The devices that walkers are split over."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import jax
import jax.numpy as jnp
from jax.sharding import AxisType, Mesh, NamedSharding, PartitionSpec
from jaxtyping import Array, Bool

from jaxwalk.common import runtime

AXIS = "walkers"

BLOCK = 32
"""Walkers that XLA moves together on a CPU's core: more would not stay in its cache (64 are about as fast,
256 a fifth slower)."""


def mesh(walkers: int | None = None) -> Mesh:
    """Devices along `AXIS`: all, or as many as ``walkers`` can be split evenly over."""
    count = jax.device_count()
    if walkers is not None:
        count = next(n for n in range(min(count, walkers), 0, -1) if walkers % n == 0)
    return jax.make_mesh((count,), (AXIS,), axis_types=(AxisType.Auto,), devices=jax.devices()[:count])


def local(mesh: Mesh) -> Mesh:
    """Those devices of ``mesh`` that are this process's own."""
    own = [device for device in mesh.devices.flat if device.process_index == jax.process_index()]
    return jax.make_mesh((len(own),), (AXIS,), axis_types=(AxisType.Auto,), devices=own)


def here(tree: Any, mesh: Mesh) -> Any:
    """What is the same on all of ``mesh``, on those of its devices that are this process's own."""
    return jax.device_put(jax.device_get(tree), NamedSharding(local(mesh), PartitionSpec()))


def each(function: Callable[..., Any], *walkers: Any, block: int = 0) -> Any:
    """``function`` of one walker for all, of whom ``walkers`` hold the arguments, leading axis first.

    It is `jax.vmap`, in blocks, one after another: what becomes of a walker does not depend on how many
    others there are, if these make whole blocks.

    Args:
      block: walkers in one, on a CPU; 0: `BLOCK`. Elsewhere all of them are.
    """
    many = jax.vmap(function)
    count = len(jax.tree.leaves(walkers)[0])
    block = (block or BLOCK) if jax.default_backend() == "cpu" else count
    whole, rest = divmod(count, block)
    if whole == 1 and not rest:
        return many(*walkers)
    # Not lax.map's own batch_size: it fails on arrays without elements, as mjx.Data has some.
    blocks = jax.tree.map(lambda x: x[: count - rest].reshape(whole, block, *x.shape[1:]), walkers)
    parts = []
    if whole:
        moved = jax.lax.map(lambda one: many(*one), blocks)
        parts.append(jax.tree.map(lambda x: x.reshape(whole * block, *x.shape[2:]), moved))
    if rest:
        parts.append(many(*jax.tree.map(lambda x: x[count - rest :], walkers)))
    return parts[0] if len(parts) == 1 else jax.tree.map(lambda *x: jnp.concatenate(x), *parts)


@jax.custom_batching.custom_vmap
def anywhere(holds: Bool[Array, ""]) -> Bool[Array, ""]:
    """``holds``; under `jax.vmap`, whether it does for any of those that are mapped over.

    It is one answer for all, so that a `jax.lax.cond` on it stays one, where ``vmap`` would compute both
    sides. For sides that do nothing to whom it does not concern.
    """
    return holds


@anywhere.def_vmap
def _anywhere(size: int, batched: list[bool], holds: Bool[Array, "N"]) -> tuple[Bool[Array, ""], bool]:
    return anywhere(jnp.any(holds)), False


def spread(function: Callable[..., Any], mesh: Mesh, split: tuple[bool, ...]) -> Callable[..., Any]:
    """``function`` of walkers, compiled to run on all of ``mesh``; its last argument is given up to it.

    Args:
      function: its result's arrays all have a leading axis of walkers.
      split: for each argument, whether it has that axis too; what has none is the same everywhere.
    """
    specs = tuple(PartitionSpec(AXIS) if one else PartitionSpec() for one in split)
    mapped = jax.shard_map(
        function, mesh=mesh, in_specs=specs, out_specs=PartitionSpec(AXIS), check_vma=False
    )
    return jax.jit(mapped, donate_argnums=len(split) - 1)


def alike(function: Callable[..., Any], mesh: Mesh, split: tuple[bool, ...]) -> Callable[..., Any]:
    """As `spread`, but each device runs the program that a single one would.

    So a walk is the same, bit for bit, on any number of devices: a program that is partitioned for several
    rounds otherwise. It costs a compilation for each device.
    """
    program = jax.jit(function, donate_argnums=len(split) - 1)
    called = runtime.as_ours()(lambda arguments: program(*arguments))  # JAX's settings are each thread's
    rows, whole = NamedSharding(mesh, PartitionSpec(AXIS)), NamedSharding(mesh, PartitionSpec())

    def run(*arguments: Any) -> Any:
        placed = [jax.device_put(x, rows if one else whole) for x, one in zip(arguments, split, strict=True)]
        leaves, tree = jax.tree.flatten(placed)
        shards = [{shard.device: shard.data for shard in leaf.addressable_shards} for leaf in leaves]
        # On a CPU a program runs in the thread that calls it.
        with ThreadPoolExecutor(mesh.size) as threads:
            mine = ([shard[device] for shard in shards] for device in mesh.devices.flat)
            done = list(threads.map(lambda leaves: called(jax.tree.unflatten(tree, leaves)), mine))

        def joined(*parts: Any) -> Any:
            shape = (len(parts) * parts[0].shape[0], *parts[0].shape[1:])
            return jax.make_array_from_single_device_arrays(shape, rows, parts)

        return jax.tree.map(joined, *done)

    return run
