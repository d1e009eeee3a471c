"""A run folder: what was asked, what happened, what came of it. Made once, never overwritten.

config.json       configuration, seed, command, hardware, versions
metrics.jsonl     one line for each report of the training loop
events.out.*      the same for TensorBoard
checkpoints/      the policy at each evaluation
resume/           the training's own state while it runs, to go on from after a kill
policy.safetensors, training.png, summary.json   written by the training loop as it goes
"""

from __future__ import annotations

import contextlib
import datetime
import errno
import fcntl
import hashlib
import itertools
import os
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

from jaxwalk.common import files, runtime, untrusted
from jaxwalk.common.errors import UserError
from jaxwalk.common.files import to_json, write_json
from jaxwalk.config import Config, of_dict, to_dict, validate
from jaxwalk.learn.runs.events import Events

CONFIG, METRICS, SUMMARY = "config.json", "metrics.jsonl", "summary.json"
POLICY, CHECKPOINTS, PICTURE = "policy.safetensors", "checkpoints", "training.png"
RESUME = "resume"
MAX_METRICS = 64 * 2**20  # bytes; a training of hours has a megabyte
_CURE = "give a run folder of jaxwalk train"
_NO_LOCKS = {errno.ENOSYS, errno.ENOTSUP, errno.EOPNOTSUPP, errno.ENOLCK, errno.EINVAL}  # Lustre, some NFS
_OURS = (CONFIG, METRICS, SUMMARY, POLICY, CHECKPOINTS, PICTURE, RESUME)


class RunFolder:
    """An open run folder, of one run at a time. Use it as a context manager, or ``close`` it.

    Of a run's processes, the first one writes; in the others, all that writes does nothing.

    Attributes:
      path: the folder.
      policy, picture: where the best policy and the training curves belong.
      checkpoints: an existing folder for the policies at each evaluation.
      resume: where the training's own state belongs.
      writes: whether this process is the one that does.

    Raises:
      UserError: another process has it open.
      OSError: it cannot be written.
    """

    def __init__(self, path: Path, writes: bool = True) -> None:
        self.path = path
        self.policy = path / POLICY
        self.picture = path / PICTURE
        self.checkpoints = path / CHECKPOINTS
        self.resume = path / RESUME
        self.writes = writes
        self._purge: int | None = None
        self._events: Events | None = None
        self._unshown: OSError | None = None  # why TensorBoard gets no more
        if not self.writes:
            return
        self._metrics = (path / METRICS).open("a")
        try:
            fcntl.flock(self._metrics, fcntl.LOCK_EX | fcntl.LOCK_NB)  # freed however the process ends
        except BlockingIOError:
            self._metrics.close()
            raise UserError(f"{path} is in use by another jaxwalk: wait until it has ended") from None
        except OSError as error:
            if error.errno not in _NO_LOCKS:
                self._metrics.close()
                raise
            print(f"no locks on the file system of {path}: see that no other jaxwalk uses it", flush=True)

    @classmethod
    def create(cls, path: Path | None, config: Config, seed: int, command: str) -> RunFolder:
        """A new run folder, ``runs/YYYYmmdd-HHMMSS`` unless ``path`` is given.

        Raises:
          UserError: the folder holds a run already, or cannot be written.
        """
        if path is None:
            path = dated()
        else:
            check_free(path)
        record = {"config": to_dict(config), "seed": seed, "command": command, **runtime.hardware()}
        record["versions"]["stepper"] = _stepper(config)
        try:
            (path / CHECKPOINTS).mkdir(parents=True)
        except OSError as error:
            check_free(path)  # somebody else may have begun a run there just now
            raise UserError(_unwritable(path, error.strerror or str(error))) from error
        try:
            write_json(path / CONFIG, record)
            return cls(path)
        except (OSError, UserError) as error:
            for name in (CONFIG, METRICS):
                (path / name).unlink(missing_ok=True)
            (path / CHECKPOINTS).rmdir()  # or a second try would find a run
            if isinstance(error, UserError):
                raise
            raise UserError(_unwritable(path, error.strerror or str(error))) from error

    @classmethod
    def reopen(cls, path: Path) -> RunFolder:
        """The folder of a run that has begun.

        Raises:
          UserError: there is no run in it, another process has it open, or it cannot be written.
        """
        if not os.path.isfile(path / METRICS):
            raise UserError(f"no run in {path}: give --resume a run folder of jaxwalk train")
        try:
            return cls(path)
        except OSError as error:
            raise UserError(
                f"cannot write the run folder {path}: {error.strerror or error}; make it writable to resume"
            ) from error

    def candidate(self, footsteps: int) -> Path:
        """Where the policy of an evaluation is kept."""
        return self.checkpoints / f"{footsteps:09d}.safetensors"

    def keep(self, count: int) -> list[dict[str, Any]]:
        """The first ``count`` rows of the metrics, which are cut there; TensorBoard forgets the same.

        Raises:
          UserError: there are fewer, or one is damaged; nothing is cut then.
        """
        file = self.path / METRICS
        lines = _lines(file)
        if len(lines) < count:
            raise UserError(f"{file} has {len(lines)} lines, its checkpoint knows {count}: begin a new run")
        rows = _rows(file, lines[:count])
        if not self.writes:
            return rows
        last = max((row["footsteps"] for row in rows), default=-1)
        os.truncate(file, sum(len(line) + 1 for line in lines[:count]))
        self._purge = 1 + last
        return rows

    def sync(self) -> None:
        """See that all metrics so far outlive a loss of power."""
        if self.writes:
            os.fsync(self._metrics.fileno())

    def log(self, row: Mapping[str, Any]) -> None:
        """Append one line of scalars; ``row["footsteps"]`` is TensorBoard's step."""
        if not self.writes:
            return
        self._metrics.write(to_json(row) + "\n")
        self._metrics.flush()  # a killed run keeps every line
        if self._unshown is None:
            try:
                self._events = self._events or Events(self.path, self._purge)
                scalars = {name: float(value) for name, value in row.items() if name != "footsteps"}
                self._events.log(int(row["footsteps"]), scalars)
            except OSError as error:  # no reason to end a run, whose numbers metrics.jsonl holds
                self._unshown = error
                print(f"TensorBoard gets no more of {self.path}: {error.strerror}", flush=True)

    def write_summary(self, summary: Mapping[str, Any]) -> None:
        """Write ``summary.json``, whole or not at all."""
        if self.writes:
            write_json(self.path / SUMMARY, summary)

    def drop_summary(self) -> None:
        """The run goes on: what was summed up when it stopped holds no more."""
        if self.writes:
            (self.path / SUMMARY).unlink(missing_ok=True)

    def close(self) -> None:
        """Close the files of the metrics; nothing can be logged after it."""
        if not self.writes:
            return
        try:
            self._metrics.close()
        finally:
            if self._events is not None:
                with contextlib.suppress(OSError):
                    self._events.close()

    def __enter__(self) -> RunFolder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        # What went wrong first is what is told: on a full disk, the last lines cannot be written either.
        with contextlib.suppress(OSError) if error else contextlib.nullcontext():
            self.close()


def check_free(path: Path) -> None:
    """See that a run can be put into ``path``, without touching it.

    Raises:
      UserError: it holds a run already, or cannot be made or written.
    """
    check_none("--run-dir", path)
    if problem := files.unusable(path):
        raise UserError(_unwritable(path, problem))


def check_none(option: str, path: Path, but: Collection[str] = ()) -> None:
    """See that nothing of a run would be overwritten in ``path``.

    Args:
      but: names that are no sign of one.

    Raises:
      UserError: it holds a run.
    """
    held = [name for name in _OURS if name not in but and os.path.lexists(path / name)]
    if held:
        raise UserError(f"{path} already holds a run ({held[0]}): give {option} another folder")


def identity(path: Path) -> str:
    """What tells the run in ``path`` from all others: SHA-256 of its ``config.json``."""
    return hashlib.sha256(untrusted.content(path / CONFIG, untrusted.MAX_JSON, _CURE)).hexdigest()


def load_record(path: Path) -> dict[str, Any]:
    """What ``config.json`` says of a run: its configuration, seed, command, hardware, versions.

    Args:
      path: the run folder, or its ``config.json``.

    Raises:
      UserError: there is none.
    """
    file = path / CONFIG if os.path.isdir(path) else path
    record = untrusted.read_json(file, _CURE)
    if not isinstance(record, dict) or "config" not in record:
        raise UserError(f"{file} holds no configuration: {_CURE}")
    return record


@dataclass(frozen=True)
class Origin:
    """Where a run of ``jaxwalk train`` comes from: its seed, its command, and what it was computed with."""

    seed: int
    command: str
    versions: Mapping[str, str]


def load_origin(path: Path) -> Origin:
    """What ``config.json`` says of how a run was begun.

    Args:
      path: the run folder.

    Raises:
      UserError: there is none, or it is none of ``jaxwalk train``.
    """
    record = load_record(path)
    seed, command, versions = (record.get(name) for name in ("seed", "command", "versions"))
    if (
        type(seed) is not int
        or not 0 <= seed < 2**32
        or not isinstance(command, str)
        or not isinstance(versions, dict)
        or not all(isinstance(one, str) for one in versions.values())
    ):
        raise UserError(f"{path / CONFIG} lacks seed, command or versions: {_CURE}")
    if command.split()[:2] != ["jaxwalk", "train"] and not command.startswith("jaxwalk.train("):
        raise UserError(
            f"the run in {path} was begun by {command!r:.60}: only jaxwalk train goes on with a run"
        )
    return Origin(seed, command, versions)


def load_config(path: Path) -> Config:
    """The configuration of a run.

    Args:
      path: the run folder, or its ``config.json``.

    Raises:
      UserError: there is none, or it is not one that this version understands and can run.
    """
    record = load_record(path)
    try:
        config = of_dict(record["config"])
        validate.check(config)
        return config
    except UserError as error:
        raise UserError(f"{path / CONFIG if os.path.isdir(path) else path}: {error}") from error


def read_summary(path: Path) -> dict[str, Any]:
    """What a run folder's ``summary.json`` tells; nothing where there is none (a run under way, or killed).

    Raises:
      UserError: it cannot be read, or is damaged.
    """
    file = path / SUMMARY
    if not os.path.lexists(file):
        return {}
    summary = untrusted.read_json(file, _CURE)
    if not isinstance(summary, dict):
        raise UserError(f"{file} holds no summary: {_CURE}")
    return summary


def read_metrics(path: Path) -> list[dict[str, Any]]:
    """The rows of a run folder's ``metrics.jsonl``, less a last line cut short.

    Raises:
      UserError: it cannot be read, or is damaged.
    """
    file = path / METRICS
    return _rows(file, _lines(file))


def _lines(file: Path) -> list[bytes]:
    return untrusted.content(file, MAX_METRICS, _CURE).split(b"\n")[:-1]


def _rows(file: Path, lines: Sequence[bytes]) -> list[dict[str, Any]]:
    rows = []
    for number, line in enumerate(lines, 1):
        try:
            row = untrusted.parse(line)
        except untrusted.Bad as bad:
            raise UserError(f"{file} is damaged in line {number}: {bad}; begin a new run") from None
        if not isinstance(row, dict) or type(row.get("footsteps")) is not int:
            raise UserError(f"{file} is damaged in line {number}: no footsteps; begin a new run")
        rows.append(row)
    return rows


def dated() -> Path:
    """A new folder named by the date and the time.

    Raises:
      UserError: it cannot be made.
    """
    stem = Path("runs") / datetime.datetime.now().strftime("%Y%m%d-%H%M%S")
    for count in itertools.count(1):
        path = stem if count == 1 else stem.with_name(f"{stem.name}-{count}")
        try:
            path.parent.mkdir(exist_ok=True)
            path.mkdir()  # whoever comes second within a second takes the next name
            return path
        except FileExistsError:
            check_free(path.parent / "new")  # unless "runs" itself is in the way
        except OSError as error:
            raise UserError(_unwritable(path, error.strerror or str(error))) from error
    raise AssertionError  # there are names enough


def _unwritable(path: Path, reason: str) -> str:
    return f"cannot write the run folder {path}: {reason}; give --run-dir a folder that can be written"


def _stepper(config: Config) -> str:
    from jaxwalk.task import backend  # imports JAX, which readers of run folders do without

    return backend.stepper_of(config)


def say_what_changed(versions: Mapping[str, str], config: Config) -> None:
    """Tell what is not that with which a run was begun: packages, and what steps its walkers.

    Args:
      versions: then, by name. config: of the run.
    """
    now = runtime.versions()["versions"] | {"stepper": _stepper(config)}
    other = [f"{name} {old} (now {now.get(name)})" for name, old in versions.items() if now.get(name) != old]
    if other:
        print(f"begun with {', '.join(other)}: goes on, but perhaps not bit for bit", flush=True)
