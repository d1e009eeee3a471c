"""A command that runs as several processes: how they find each other, and how they end.

`jax.distributed` does the finding and watches over the processes by heartbeats. When one of them is lost it
aborts the others with pages of C++; here that becomes one line.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import re
import signal
import socket
import sys
import tempfile
import time
import traceback
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from jaxwalk.common import environment
from jaxwalk.common.errors import Agreed, UserError

LOST = 3  # exit code: another process has gone
CONNECT_SECONDS = 120
HEARTBEAT_SECONDS = 20  # without any, a process counts as lost
_SILENT = re.compile(r"stopped sending heartbeats\):\s*((?:\d+\s+)+)")
_FATAL = "JAX distributed service detected fatal errors"


@dataclass(frozen=True)
class Place:
    """Where a process finds the others; nothing where SLURM, Kubernetes or MPI tells.

    Attributes:
      coordinator: HOST:PORT of process 0. processes: how many. process_id: which one this is, from 0.
    """

    coordinator: str | None = None
    processes: int | None = None
    process_id: int | None = None

    def check(self) -> None:
        """See that the options can be meant.

        Raises:
          UserError: one without the others, or out of its range.
        """
        given = {
            "--coordinator": self.coordinator,
            "--processes": self.processes,
            "--process-id": self.process_id,
        }
        missing = [name for name, value in given.items() if value is None]
        if missing and len(missing) < len(given):
            raise UserError(
                f"{' and '.join(missing)} missing: give --coordinator HOST:PORT, --processes N and "
                "--process-id K together, or none of them under SLURM, Kubernetes or MPI"
            )
        if self.coordinator is None or self.processes is None or self.process_id is None:
            return
        host, _, port = self.coordinator.rpartition(":")
        if not host or not port.isascii() or not port.isdecimal() or not 0 < int(port) < 65536:
            raise UserError(f"--coordinator {self.coordinator}: give HOST:PORT of process 0, port 1 to 65535")
        if self.processes < 1:
            raise UserError(f"--processes {self.processes}: give a whole number, 1 or more")
        if not 0 <= self.process_id < self.processes:
            raise UserError(f"--process-id {self.process_id}: give 0 to {self.processes - 1}, each once")


@contextlib.contextmanager
def joined(place: Place, go_on: str) -> Iterator[None]:
    """The other processes are there. To be entered before JAX computes; ends the process if it fails.

    Args:
      go_on: what to do when a process was lost.

    Raises:
      UserError: the others were not found.
      Agreed: what all processes know of, in the first one. The others end without a word.
    """
    import jax

    # Else CPUs of different processes cannot add up.
    jax.config.update("jax_cpu_collectives_implementation", "gloo")
    with _Quiet(go_on) as quiet:
        _connect(place)
        quiet.connected = True
        try:
            environment.start_devices()
            _check_alike()
            yield
        except Agreed:
            jax.distributed.shutdown()
            if jax.process_index():
                raise SystemExit(2) from None
            raise
        except UserError as error:
            quiet.end(f"jaxwalk: error: {error}", 2)
        except KeyboardInterrupt:
            quiet.end("jaxwalk: interrupted", 130)
        except jax.errors.JaxRuntimeError:
            # Most likely a message to one that is lost. JAX soon knows which, and ends this process.
            told = traceback.format_exc()
            time.sleep(HEARTBEAT_SECONDS * 1.5)
            quiet.end(quiet.said() + told, 1)
        except BaseException:
            quiet.end(quiet.said() + traceback.format_exc(), 1)
        jax.distributed.shutdown()


def _connect(place: Place) -> None:
    """Join the other processes.

    Raises:
      UserError: the others were not found.
    """
    import jax

    if place.coordinator is not None and place.process_id == 0:
        _check_free(place.coordinator)
    elif place.coordinator is not None:
        _reach(place.coordinator)
    try:
        jax.distributed.initialize(
            place.coordinator,
            place.processes,
            place.process_id,
            initialization_timeout=CONNECT_SECONDS,
            heartbeat_timeout_seconds=HEARTBEAT_SECONDS,
        )
    except ValueError as error:
        raise UserError(
            "no SLURM, Kubernetes or MPI that JAX knows: give --coordinator HOST:PORT --processes N "
            f"--process-id K ({error})"
        ) from error
    except (RuntimeError, OSError) as error:
        raise _unfound() from error


def _unfound() -> UserError:
    return UserError(
        f"the processes did not find each other within {CONNECT_SECONDS} s: start all of them, with one "
        "--coordinator that they can reach and a free port"
    )


def _check_alike() -> None:
    """See that all processes have equally many devices.

    Raises:
      Agreed: one process has more devices than another.
    """
    import jax

    count, processes = jax.device_count(), jax.process_count()
    if any(
        sum(device.process_index == one for device in jax.devices()) * processes != count
        for one in range(processes)
    ):
        raise Agreed(
            f"{count} devices in {processes} processes: give each as many as the others, on CPUs with "
            "JAX_NUM_CPU_DEVICES=N"
        )


def _check_free(coordinator: str) -> None:
    """See that nobody listens at the address of the first process yet.

    Raises:
      UserError: somebody listens already where the first process is to.
    """
    try:
        socket.create_server(("", int(coordinator.rpartition(":")[2]))).close()
    except OSError as error:
        raise UserError(
            f"--coordinator {coordinator}: {error.strerror or error}: give a free port of this machine"
        ) from error


def _reach(coordinator: str) -> None:
    """Wait until the first process listens.

    Raises:
      UserError: it does not.
    """
    host, _, port = coordinator.rpartition(":")
    begun, reason = time.monotonic(), ""
    while time.monotonic() - begun < CONNECT_SECONDS:
        try:
            socket.create_connection((host.strip("[]"), int(port)), timeout=5).close()
            return
        except OSError as error:
            reason = error.strerror or str(error)
            time.sleep(0.5)
    raise UserError(
        f"no process 0 at --coordinator {coordinator} within {CONNECT_SECONDS} s ({reason}): start it, and "
        "give all processes an address of it that they can reach"
    )


class _Quiet:
    """Keeps what C++ says to itself, and makes one line of JAX's abort when a process is lost."""

    def __init__(self, go_on: str) -> None:
        self._go_on = go_on
        self.connected = False  # whether the processes have found each other

    def __enter__(self) -> _Quiet:
        sys.stderr.flush()
        self._said = tempfile.TemporaryFile()
        self._stderr = os.dup(2)
        os.dup2(self._said.fileno(), 2)
        self._old = sys.stderr
        sys.stderr = os.fdopen(os.dup(self._stderr), "w", buffering=1)
        self._handler = ctypes.CFUNCTYPE(None, ctypes.c_int)(
            self._aborted
        )  # lives as long as it may be called
        # Python's own handlers run in the main thread, once it is back from what it waits for: too late.
        ctypes.CDLL(None).signal(signal.SIGABRT, self._handler)
        return self

    def __exit__(self, *_: object) -> None:
        ctypes.CDLL(None).signal(signal.SIGABRT, ctypes.c_void_p(0))
        sys.stderr.close()
        sys.stderr = self._old
        os.dup2(self._stderr, 2)
        os.close(self._stderr)

    def said(self) -> str:
        """What C++ has said so far."""
        return os.pread(self._said.fileno(), 2**20, 0).decode(errors="replace")

    def end(self, line: str, code: int) -> None:
        """End this process at once: others may be lost, and waiting for them in vain."""
        with contextlib.suppress(Exception):
            sys.stdout.flush()
        os.write(self._stderr, (line.rstrip("\n") + "\n").encode())
        os._exit(code)

    def _aborted(self, _: Any) -> None:
        said = self.said()
        if not self.connected:
            self.end(f"jaxwalk: error: {_unfound()}", 2)
        if _FATAL not in said:
            self.end(said, 128 + signal.SIGABRT)
        silent = _SILENT.findall(said)
        which = f"process {' and '.join(silent[-1].split())}" if silent else "process 0, the coordinator,"
        self.end(f"jaxwalk: error: {which} has gone (see its own output); {self._go_on}", LOST)
