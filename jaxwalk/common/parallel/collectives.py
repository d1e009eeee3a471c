"""What the processes of one run settle between them. Alone, each function gives what it is given.

All processes must call these in the same order, as they must call all programs on arrays that are split
over the devices of several.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import jax
import numpy as np

from jaxwalk.common.errors import Agreed, UserError

_LONGEST = 4096  # bytes of a text
_PATIENCE_MS = 3_600_000  # for the slowest process, which may compile while the others have done so before
_turns = itertools.count()


def count() -> int:
    """Processes of this run, 1 where it is alone."""
    return jax.process_count()


def first() -> bool:
    """Whether this process is the one that writes and tells."""
    return jax.process_index() == 0


def barrier() -> None:
    """Wait until all processes have come so far. Messages between CPUs (Gloo) give up after half a minute."""
    if count() > 1:
        from orbax.checkpoint import multihost  # slow to import

        multihost.get_barrier_sync_fn()(key=f"jaxwalk.{next(_turns)}", timeout_ms=_PATIENCE_MS)


def broadcast(say: Callable[[], str]) -> str:
    """What ``say`` gives in the first process, in all of them.

    Raises:
      Agreed: what it raised there as a `UserError`.
    """
    if count() == 1:
        return say()
    from jax.experimental import multihost_utils

    failed, text = False, ""
    if first():
        try:
            text = say()
        except UserError as error:
            failed, text = True, str(error)
    data = np.zeros(_LONGEST, np.uint8)
    raw = text.encode()[: _LONGEST - 1]
    data[0], data[1 : 1 + len(raw)] = failed, np.frombuffer(raw, np.uint8)
    barrier()
    data = np.asarray(multihost_utils.broadcast_one_to_all(data))
    text = data[1:].tobytes().rstrip(b"\0").decode(errors="replace")
    if data[0]:
        raise Agreed(text)
    return text


def any_process(*wishes: bool) -> tuple[bool, ...]:
    """Each wish, whether any process has it."""
    if count() == 1:
        return wishes
    return tuple(bool(one) for one in gather(np.array(wishes)[None]).any(axis=0))


def share(rows: int) -> np.ndarray:
    """Which of ``rows`` this process takes: as many as each other one, so that some may come twice."""
    each = -(-rows // count())
    return (jax.process_index() * each + np.arange(each)) % rows


def gather(tree: Any) -> Any:
    """Arrays on the host with a leading axis, those of all processes one after another, bit for bit."""
    if count() == 1:
        return tree
    from jax.experimental import multihost_utils

    leaves, structure = jax.tree.flatten(jax.tree.map(np.asarray, tree))
    flat = [np.ascontiguousarray(x).reshape(len(x), -1).view(np.uint8) for x in leaves]
    ends = np.cumsum([x.shape[1] for x in flat])[:-1]
    barrier()
    # One message: each costs the compilation of a program.
    everything = np.asarray(multihost_utils.process_allgather(np.concatenate(flat, axis=1), tiled=True))
    parts = [
        np.ascontiguousarray(part).view(x.dtype).reshape(-1, *x.shape[1:])
        for part, x in zip(np.split(everything, ends, axis=1), leaves, strict=True)
    ]
    return jax.tree.unflatten(structure, parts)
