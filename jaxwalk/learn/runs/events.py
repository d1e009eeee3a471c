"""A run's numbers for TensorBoard, written by who logs them: no other thread can die of a full disk."""

from __future__ import annotations

import importlib
import math
import socket
import struct
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

_PREFIX = "events.out.tfevents."


class Events:
    """A file of TensorBoard's events, beside those that earlier processes of the run have left.

    Args:
      purge: the step from which on TensorBoard forgets what those hold; None: nothing of it.

    Raises:
      OSError: it cannot be written.
    """

    def __init__(self, folder: Path, purge: int | None) -> None:
        # Slow to import, and readers of run folders do without. Its own writer has a thread and a queue.
        self._kinds: Any = importlib.import_module("tensorboardX.proto.event_pb2")
        self._scalar: Any = importlib.import_module("tensorboardX.summary").scalar
        self._checksum: Any = importlib.import_module("tensorboardX.record_writer").masked_crc32c
        # TensorBoard reads files in the order of their names, which a clock set back must not change.
        last = max((_second(path) for path in folder.glob(f"{_PREFIX}*")), default=0)
        name = f"{_PREFIX}{max(int(time.time()), last + 1):010}.{socket.gethostname()}"
        self._file = (folder / name).open("xb")
        self._write(file_version="brain.Event:2")
        if purge is not None:
            start = self._kinds.SessionLog(status=self._kinds.SessionLog.START)
            self._write(step=purge, session_log=start)

    def log(self, step: int, values: Mapping[str, float]) -> None:
        """Append the finite ones of ``values``.

        Raises:
          OSError: it cannot be written.
        """
        for name, value in values.items():
            if math.isfinite(value):
                self._write(step=step, summary=self._scalar(name, value))
        self._file.flush()

    def close(self) -> None:
        """Nothing can be logged after it."""
        self._file.close()

    def _write(self, **parts: Any) -> None:
        event = self._kinds.Event(wall_time=time.time(), **parts).SerializeToString()
        length = struct.pack("<Q", len(event))
        for part in (length, event):
            self._file.write(part + struct.pack("<I", self._checksum(part)))


def _second(path: Path) -> int:
    told = path.name.removeprefix(_PREFIX).partition(".")[0]
    return int(told) if told.isascii() and told.isdigit() and len(told) <= 10 else 0
