"""The trials' results on disk: one file that grows, and is never half written."""

from __future__ import annotations

import io
import json
import os
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jaxwalk.common import files, untrusted, untrusted_arrays
from jaxwalk.common.errors import UserError
from jaxwalk.measure.push_map.grid import Grid

NAME = "map.npz"
RESULTS = {
    "survived": np.bool_,  # met its push and walks on at the end
    "fall_seconds": np.float32,  # after the push began; NaN for who is up or met none
    "recovery_seconds": np.float32,  # from the push's end to steady; NaN for who never was
    "impulse_delivered": np.float32,  # N s
    "longest": np.float32,  # step, m
    "shortest": np.float32,  # step, s
}

_MOST_PER_TRIAL = 256  # bytes; columns of numbers and the point's name
_CURE = "give --out another folder"


@dataclass
class Table:
    """Results of a grid's trials, in its order; rows that are not ``done`` mean nothing yet.

    Attributes:
      grid: what is tried.
      identity: what else decides the results (policy, configuration), as JSON values.
      done: [size].
      columns: [size] each of `RESULTS`.
    """

    grid: Grid
    identity: dict[str, Any]
    done: NDArray[np.bool_]
    columns: dict[str, NDArray]

    @classmethod
    def empty(cls, grid: Grid, identity: dict[str, Any]) -> Table:
        """A table in which no trial is done yet."""
        columns = {name: np.zeros(grid.size, kind) for name, kind in RESULTS.items()}
        return cls(grid, identity, np.zeros(grid.size, np.bool_), columns)

    def put(self, rows: NDArray[np.integer], values: dict[str, NDArray]) -> None:
        """Fill in finished trials."""
        for name, column in self.columns.items():
            column[rows] = values[name]
        self.done[rows] = True

    def save(self, folder: Path) -> None:
        """Replace the folder's table.

        Raises:
          UserError: it cannot be written; the old one stands.
        """
        buffer = io.BytesIO()
        about = np.array(_about(self.grid, self.identity))
        arrays: dict[str, Any] = {"about": about, "done": self.done, **self.grid.columns(), **self.columns}
        np.savez_compressed(buffer, **arrays)
        files.write_bytes(folder / NAME, buffer.getvalue())


def resume(folder: Path, grid: Grid, identity: dict[str, Any]) -> Table:
    """The folder's table if it holds the same map, else an empty one.

    Raises:
      UserError: it holds another map, or a file that is none.
    """
    path = folder / NAME
    if not os.path.lexists(path):
        return Table.empty(grid, identity)
    most = 2**20 + _MOST_PER_TRIAL * grid.size
    content = untrusted.content(path, most, _CURE)
    try:
        stored = untrusted_arrays.npz(content, most)
    except untrusted.Bad as bad:
        raise UserError(untrusted.unreadable(path, bad, _CURE)) from None
    kinds = {"done": np.bool_, **RESULTS}
    if not {"about", *kinds} <= stored.keys() or stored["about"].dtype.kind != "U":
        raise UserError(f"{path} is no push map: {_CURE}")
    if str(stored["about"]) != _about(grid, identity):
        raise UserError(
            f"{path} holds the map of another policy, grid, seed or engine: {_CURE}, "
            "or the same options to go on with it"
        )
    if any((stored[name].shape, stored[name].dtype) != ((grid.size,), kind) for name, kind in kinds.items()):
        raise UserError(f"{path} is a damaged push map: {_CURE}")
    columns = {name: stored[name].copy() for name in RESULTS}
    return Table(grid, identity, stored["done"].copy(), columns)


def _about(grid: Grid, identity: dict[str, Any]) -> str:
    return json.dumps({"grid": asdict(grid), **identity}, sort_keys=True)
