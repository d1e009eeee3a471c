"""Checkpoints of a training run, by Orbax: written beside the training, whole or not at all, two kept.

A digest of all that a checkpoint holds travels within it, so that one cut short, altered or brought
from another run is told from a good one. Where a run has several processes, each writes and digests what
its devices hold, and each reads everything.
"""

from __future__ import annotations

import errno
import hashlib
import json
import math
import os
import shutil
import stat
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import jax
import jax.numpy as jnp
import numpy as np

from jaxwalk.common.errors import UserError
from jaxwalk.common.parallel import collectives

KEPT = 2
_NOT_ITS_FAULT = {errno.EMFILE, errno.ENFILE, errno.EIO, errno.ENOMEM}
_MOST_BESIDE = 64 * 2**20  # bytes of a checkpoint's files that are no numbers of its arrays
_MOST_PARTS = 2**20  # processes that wrote a checkpoint
_ARRAYS, _REST = "arrays", "rest"
T = TypeVar("T")


@dataclass(frozen=True)
class Checkpoint:
    """A run's state, as it is saved.

    Attributes:
      arrays: by name; owned by nobody else. On the host, or as `pack` leaves them on the devices.
      notes: JSON values with text for keys.
    """

    arrays: Mapping[str, np.ndarray | jax.Array]
    notes: Mapping[str, Any]


class Store:
    """The checkpoints in one folder, which need not exist. ``close`` it, so that none stays half written.

    Args:
      run: what tells this run from all others; checkpoints of another are not taken for its own.
    """

    def __init__(self, folder: Path, run: str) -> None:
        import orbax.checkpoint as ocp  # two seconds to import, and other commands do without
        from orbax.checkpoint.checkpoint_managers import preservation_policy

        self.folder, self._run, self._ocp = folder, run, ocp
        options = ocp.CheckpointManagerOptions(
            preservation_policy=preservation_policy.LatestN(KEPT),
            cleanup_tmp_directories=True,  # what a killed process was about to write
        )
        try:
            self._manager = ocp.CheckpointManager(folder.absolute(), options=options)
        except OSError as error:
            raise UserError(self._unwritten(error)) from error
        self._next = max(self._manager.all_steps(), default=-1) + 1

    def save(self, checkpoint: Checkpoint, wait: bool = False) -> None:
        """Begin to write; what is called later may change nothing in it. ``wait``: until it is on disk.

        Raises:
          UserError: it cannot be written, or the one before it could not.
        """
        parts = collectives.count()
        mine = np.frombuffer(_part(checkpoint, jax.process_index(), parts), np.uint8)
        rest = {
            "run": self._run,
            "digest": _whole(checkpoint, [bytes(part) for part in collectives.gather(mine[None])]),
            "parts": parts,
            "notes": dict(checkpoint.notes),
        }
        args = self._ocp.args
        try:
            self._manager.wait_until_finished()
            self._manager.save(
                self._next,
                args=args.Composite(
                    **{_ARRAYS: args.PyTreeSave(dict(checkpoint.arrays)), _REST: args.JsonSave(rest)}
                ),
            )
            self._next += 1
        except Exception as error:  # Orbax and TensorStore have many
            raise UserError(self._unwritten(error)) from error
        if wait:
            self.wait()

    def wait(self) -> None:
        """Until what is being written is on disk.

        Raises:
          UserError: it cannot be written.
        """
        try:
            self._manager.wait_until_finished()
        except Exception as error:
            raise UserError(self._unwritten(error)) from error

    def busy(self) -> bool:
        """Whether a checkpoint is being written.

        Raises:
          UserError: it could not be.
        """
        try:
            self._manager.check_for_errors()
            return self._manager.is_saving_in_progress()
        except Exception as error:
            raise UserError(self._unwritten(error)) from error

    def latest(self, say: Callable[[str], None], most: int) -> Checkpoint | None:
        """The latest checkpoint that is whole; those after it are dropped, and ``say`` is told of each.

        None: there are no checkpoints at all.

        Args:
          most: bytes that the arrays of one may have.

        Raises:
          UserError: there are some, but none of them can be used.
        """
        bad: list[tuple[int, str]] = []
        for step in sorted(self._manager.all_steps(), reverse=True):
            found = self._read(step, most)
            if isinstance(found, Checkpoint):
                for worse, why in bad:
                    say(f"checkpoint {worse} {why}: going on from the one before it")
                    self._manager.delete(worse)
                return found
            bad.append((step, found))
        if bad:
            raise UserError(
                f"no checkpoint in {self.folder} can be used: number {bad[0][0]} {bad[0][1]}; begin a new run"
            )
        return None

    def _read(self, step: int, most: int) -> Checkpoint | str:
        """A checkpoint, or what is wrong with it."""
        args = self._ocp.args
        try:
            self._check_size(step, most)
            read = self._manager.restore(
                step,
                args=args.Composite(
                    **{
                        _ARRAYS: args.PyTreeRestore(restore_args=self._as_numpy(step)),
                        _REST: args.JsonRestore(),
                    }
                ),
            )
            arrays = {name: np.asarray(x) for name, x in read[_ARRAYS].items()}
            found, rest = Checkpoint(arrays, read[_REST]["notes"]), read[_REST]
            parts = rest.get("parts", 1)
            if type(parts) is not int or not 0 < parts <= _MOST_PARTS:
                return "is damaged (its parts are no number)"
            if digest(found, parts) != rest["digest"]:
                return "is damaged (its digest differs)"
            return found if rest["run"] == self._run else "is of another run"
        except (MemoryError, PermissionError) as error:  # the checkpoint may be a good one
            raise UserError(f"cannot read the checkpoint {self.folder / str(step)}: {error}") from error
        except Exception as error:  # whatever a damaged file makes of its readers
            if isinstance(error, OSError) and error.errno in _NOT_ITS_FAULT:
                raise UserError(f"cannot read the checkpoint {self.folder / str(step)}: {error}") from error
            return f"is damaged ({_first_line(error)})"

    def _arrays(self, step: int) -> dict[str, Any]:
        """What a checkpoint says of its arrays."""
        reader = self._ocp.PyTreeCheckpointHandler()
        return reader.metadata(self.folder.absolute() / str(step) / _ARRAYS).tree

    def _as_numpy(self, step: int) -> dict[str, Any]:
        """That all arrays come to the host, wherever they were."""
        return {name: self._ocp.RestoreArgs(restore_type=np.ndarray) for name in self._arrays(step)}

    def _check_size(self, step: int, most: int) -> None:
        """See, before it is read, that a checkpoint takes no more memory than one of this run.

        Raises:
          Exception: it does; or whatever a damaged file makes of its readers.
        """
        told = [os.lstat(path) for path in (self.folder / str(step)).rglob("*")]
        if not all(stat.S_ISREG(one.st_mode) or stat.S_ISDIR(one.st_mode) for one in told):
            raise ValueError("it holds something else than files and folders")
        if sum(one.st_size for one in told) > most + _MOST_BESIDE:
            raise ValueError("its files are larger than those of this run")
        arrays = self._arrays(step).values()
        # A chunk is unpacked whole, however small its array.
        sizes = (
            np.dtype(one.dtype).itemsize * max(math.prod(one.shape), math.prod(one.storage.chunk_shape))
            for one in arrays
        )
        if sum(sizes) > most:
            raise ValueError("its arrays are larger than those of this run")

    def close(self) -> None:
        """Wait for what is being written. One that failed is as if it had not been begun."""
        try:
            self._manager.close()
        except Exception as error:
            raise UserError(self._unwritten(error)) from error

    def clear(self) -> None:
        """Close, and remove the folder: the run needs it no more."""
        self.close()
        if collectives.first():
            shutil.rmtree(self.folder, ignore_errors=True)

    def _unwritten(self, error: Exception) -> str:
        # TensorStore says so of a full disk, after much else.
        reason = "no space left" if "RESOURCE_EXHAUSTED" in str(error) else _first_line(error)
        return (
            f"cannot write a checkpoint into {self.folder}: {reason}; "
            f"make room there, then go on with jaxwalk train --resume {self.folder.parent}"
        )


def of_run(now: Checkpoint, good: Checkpoint) -> Checkpoint:
    """A run as it is, and as it would go back to when it diverges."""
    arrays = {f"now.{name}": x for name, x in now.arrays.items()}
    arrays |= {f"good.{name}": x for name, x in good.arrays.items()}
    return Checkpoint(arrays, {"now": now.notes, "good": good.notes})


def digest(checkpoint: Checkpoint, parts: int = 1) -> str:
    """SHA-256 of names, types, shapes and bytes of all arrays, and of the notes; as ``parts`` made it."""
    return _whole(checkpoint, [_part(checkpoint, part, parts) for part in range(parts)])


def _whole(checkpoint: Checkpoint, parts: Sequence[bytes]) -> str:
    hashed = hashlib.sha256(json.dumps(checkpoint.notes, sort_keys=True).encode())
    for part in parts:
        hashed.update(part)
    return hashed.hexdigest()


def _part(checkpoint: Checkpoint, part: int, parts: int) -> bytes:
    """What one of ``parts`` processes adds to the digest: its share of the rows; the first, the rest too."""
    hashed = hashlib.sha256()
    for name in sorted(checkpoint.arrays):
        x = checkpoint.arrays[name]
        split = x.ndim > 0 and x.shape[0] % parts == 0
        if not split and part > 0:
            continue
        hashed.update(f"{name} {x.dtype} {x.shape} ".encode())
        each = x.shape[0] // parts if split else 0
        rows = _rows(x, part * each, (part + 1) * each) if split else np.asarray(x)
        hashed.update(np.ascontiguousarray(rows).tobytes())
    return hashed.digest()


def _rows(x: np.ndarray | jax.Array, start: int, stop: int) -> np.ndarray:
    """Rows of an array, of which this process may hold no more than these."""
    if not isinstance(x, jax.Array) or x.is_fully_addressable or x.is_fully_replicated:
        return np.asarray(x)[start:stop]
    held = sorted(x.addressable_shards, key=lambda shard: shard.index[0].start or 0)
    assert (held[0].index[0].start or 0, held[-1].index[0].stop) == (start, stop)
    return np.concatenate([np.asarray(shard.data) for shard in held])


def pack(tree: Any) -> dict[str, np.ndarray | jax.Array]:
    """A tree's arrays by their paths, copied; random keys as their data.

    To the host, whence they are written in a third of the time; where they lie, if other processes hold
    parts of them.
    """
    if collectives.count() == 1:
        # Copies: on a CPU, JAX hands out its own buffers, which training gives up.
        leaves = jax.tree_util.tree_leaves_with_path(jax.tree.map(_plain, tree))
        return {_name(path): np.array(x) for path, x in leaves}
    return {_name(path): x for path, x in jax.tree_util.tree_leaves_with_path(_copied(tree))}


@jax.jit
def _copied(tree: Any) -> Any:
    # Copies: training gives its own arrays up.
    return jax.tree.map(lambda x: jnp.copy(_plain(x)), tree)


def unpack(arrays: Mapping[str, np.ndarray | jax.Array], like: T, shardings: Any) -> T:
    """The tree that ``pack`` took apart, on its devices.

    Args:
      like: its types and shapes. shardings: of its arrays, a prefix of the tree.

    Raises:
      UserError: other arrays than ``like`` calls for.
    """
    check_fits(arrays, like)

    where = jax.tree.leaves(
        jax.tree.map(lambda one, part: jax.tree.map(lambda _: one, part), shardings, like)
    )
    plain = [_placed(arrays[_name(path)], one) for (path, _), one in zip(_packed(like), where, strict=True)]
    return jax.jit(partial(_wrapped, like), out_shardings=shardings)(plain)


def _placed(x: np.ndarray | jax.Array, where: Any) -> jax.Array:
    if isinstance(x, jax.Array):
        return x
    return jax.make_array_from_callback(x.shape, where, lambda index: x[index])


def _wrapped(like: T, plain: Sequence[jax.Array]) -> T:
    """A copy, as training gives its arrays up; keys are keys again."""
    tree = jax.tree.unflatten(jax.tree.structure(like), [jnp.copy(x) for x in plain])
    return jax.tree.map(lambda x, y: jax.random.wrap_key_data(y) if _is_key(x) else y, like, tree)


def check_fits(arrays: Mapping[str, np.ndarray | jax.Array], like: Any) -> None:
    """See that ``arrays`` are what `pack` makes of a tree ``like`` this.

    Raises:
      UserError: they are not.
    """
    for path, x in _packed(like):
        found = arrays.get(_name(path))
        if found is None or (found.shape, found.dtype) != (x.shape, x.dtype):
            held = "nothing" if found is None else f"{found.dtype}{list(found.shape)}"
            raise UserError(
                f"the checkpoint is of another version of jaxwalk: it holds {held} for {_name(path)}, "
                f"not {x.dtype}{list(x.shape)}; go on with the version that made it"
            )


def size(like: Any) -> int:
    """Bytes of what `pack` makes of a tree ``like`` this."""
    return sum(x.dtype.itemsize * x.size for _, x in _packed(like))


def _packed(like: Any) -> Any:
    """(path, type and shape) of each array that `pack` makes of a tree ``like`` this."""
    return jax.tree_util.tree_leaves_with_path(jax.eval_shape(lambda t: jax.tree.map(_plain, t), like))


def _is_key(x: Any) -> bool:
    return jnp.issubdtype(x.dtype, jax.dtypes.prng_key)


def _plain(x: Any) -> Any:
    return jax.random.key_data(x) if _is_key(x) else x


def _name(path: Any) -> str:
    return jax.tree_util.keystr(path, simple=True, separator=".")


def _first_line(error: Exception) -> str:
    lines = str(error).strip().splitlines()
    return lines[0][:200] if lines else type(error).__name__
