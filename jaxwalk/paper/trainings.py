"""The trainings whose policies and curves the claims compare: how each is begun, and what is kept of it."""

from __future__ import annotations

import csv
import dataclasses
import hashlib
import io
import math
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jaxwalk.common import files, untrusted
from jaxwalk.common.errors import UserError
from jaxwalk.learn.policies import policy
from jaxwalk.learn.runs import run_folder

POLICIES, CURVES = "policies", "curves"
_COLUMNS = ("footsteps", "survival", "score")
_CURE = "write it anew with jaxwalk paper --retrain"
_FULL = ("--observation", "speed", "pitch", "zmp", "step_length")


@dataclass(frozen=True)
class Training:
    """One way to train, with several seeds.

    Attributes:
      name: of its files. words: on the page.
      options: of ``jaxwalk train``, beside preset and seed.
      seeds: each is one run.
    """

    name: str
    words: str
    options: tuple[str, ...]
    seeds: tuple[int, ...] = (0, 1, 2)

    def words_of(self, seed: int, preset: str = "quick") -> list[str]:
        """The arguments that ``jaxwalk`` is given for one seed."""
        return ["train", "--preset", preset, *self.options, "--seed", str(seed)]

    def line(self, seed: int) -> str:
        """The command as one would type it into a shell."""
        return shlex.join(["jaxwalk", *self.words_of(seed)])


TRAININGS: dict[str, Training] = {
    one.name: one
    for one in (
        Training("full", "s = [v, phi, d_zmp, l]", _FULL),
        Training("pair", "s = [d_zmp, phi]", ("--observation", "zmp", "pitch")),
        Training(
            "printed",
            "learning rates 1e-8 and 2e-8",
            (*_FULL, "--ddpg.actor-lr", "1e-8", "--ddpg.critic-lr", "2e-8"),
        ),
        Training("random", "random first action", (*_FULL, "--ddpg.start", "random")),
        Training("walls", "trained between walls", ("--body.model", "walls"), (0,)),
    )
}


@dataclass(frozen=True)
class Curve:
    """What the evaluations within one training found.

    Attributes:
      footsteps: [E] gathered at each. survival: [E] share of the graded pushes. score: [E].
    """

    footsteps: tuple[float, ...]
    survival: tuple[float, ...]
    score: tuple[float, ...]


def policy_file(folder: Path, name: str, seed: int) -> Path:
    """Where ``folder`` holds the policy of one run of the training called ``name``."""
    return folder / POLICIES / f"{name}-{seed}.safetensors"


def curve_file(folder: Path, name: str, seed: int) -> Path:
    """Where ``folder`` holds the evaluations of one run of the training called ``name``, as CSV."""
    return folder / CURVES / f"{name}-{seed}.csv"


def missing(folder: Path, name: str) -> list[str]:
    """Files of the training called ``name`` that are not in ``folder``."""
    wanted = [file(folder, name, s) for s in TRAININGS[name].seeds for file in (policy_file, curve_file)]
    return [str(path.relative_to(folder)) for path in wanted if not path.is_file()]


def digest(folder: Path, names: Sequence[str]) -> str:
    """SHA-256 of all files of these trainings, absent ones included: what a measurement depends on."""
    hashed = hashlib.sha256()
    for name in names:
        for seed in TRAININGS[name].seeds:
            for path in (policy_file(folder, name, seed), curve_file(folder, name, seed)):
                content = untrusted.content(path, untrusted.MAX_JSON, _CURE) if path.is_file() else b"-"
                hashed.update(hashlib.sha256(content).digest())
    return hashed.hexdigest()


def keep(run: Path, name: str, seed: int, folder: Path, preset: str = "quick") -> None:
    """Put the policy and the curve of a finished run where the claims look for them.

    Raises:
      UserError: no such training, a run of another seed or configuration, one that is damaged or has not
        ended.
    """
    from jaxwalk.learn.train import options as command

    if name not in TRAININGS or seed not in TRAININGS[name].seeds:
        known = ", ".join(f"{one.name} ({', '.join(map(str, one.seeds))})" for one in TRAININGS.values())
        raise UserError(f"no training {name!r} of seed {seed}: give one of {known}")
    origin = run_folder.load_origin(run)
    if origin.seed != seed:
        raise UserError(f"the run in {run} has seed {origin.seed}, not {seed}: give the run of that seed")
    wanted = command.read(TRAININGS[name].words_of(seed, preset)[1:]).config
    if run_folder.load_config(run) != wanted:
        line = shlex.join(["jaxwalk", *TRAININGS[name].words_of(seed, preset)])
        raise UserError(f"the run in {run} has another configuration: give one of {line}")
    loaded = policy.load(run / run_folder.POLICY)
    said = _without_folder(origin.command)
    kept = dataclasses.replace(loaded, metadata=dataclasses.replace(loaded.metadata, command=said))
    rows = [row for row in run_folder.read_metrics(run) if row.get("eval/survival") is not None]
    if not rows or not _has_ended(run):
        raise UserError(f"the run in {run} is not over: give one that has ended")
    for part in (POLICIES, CURVES):
        files.make_folder("--trained", folder / part)
    policy.save(kept, policy_file(folder, name, seed))
    lines = [{c: row[c if c == "footsteps" else f"eval/{c}"] for c in _COLUMNS} for row in rows]
    head = f"# {said}\n".encode()
    files.write_bytes(curve_file(folder, name, seed), head + files.to_csv(lines))


def _without_folder(command: str) -> str:
    """The command of a run, less where its folder was."""
    words = shlex.split(command)
    kept = [w for i, w in enumerate(words) if "--run-dir" not in (w, w.partition("=")[0], words[i - 1])]
    return shlex.join(kept)


def _has_ended(run: Path) -> bool:
    summary = run_folder.read_summary(run)
    return bool(summary) and not summary.get("interrupted")


def curve(folder: Path, name: str, seed: int) -> Curve:
    """What `keep` wrote.

    Raises:
      UserError: it is missing or damaged.
    """
    path = curve_file(folder, name, seed)
    content = untrusted.content(path, untrusted.MAX_JSON, _CURE).decode(errors="replace")
    text = "\n".join(line for line in content.splitlines() if not line.startswith("#"))
    try:
        rows = [[float(row[column]) for column in _COLUMNS] for row in csv.DictReader(io.StringIO(text))]
        if not rows or not all(math.isfinite(x) for row in rows for x in row):
            raise ValueError
    except (KeyError, TypeError, ValueError, csv.Error):
        raise UserError(f"{path} holds no learning curve: {_CURE}") from None
    return Curve(*map(tuple, zip(*rows, strict=True)))


def train(folder: Path, runs: Path, names: Sequence[str], report: Any = print, preset: str = "quick") -> None:
    """All runs of these trainings anew, one after another; one that was interrupted goes on.

    Args:
      folder: for policies and curves. runs: for the run folders, ``NAME-SEED``.
      report: called with the command of each run as it begins.

    Raises:
      KeyboardInterrupt: a run was stopped; the next call goes on with it.
    """
    from jaxwalk.learn.train import command, options

    for name in names:
        for seed in TRAININGS[name].seeds:
            run = runs / f"{name}-{seed}"
            words = TRAININGS[name].words_of(seed, preset)
            if not _has_ended(run):
                begun = (run / run_folder.METRICS).is_file()
                report(shlex.join(["jaxwalk", *words]))
                argv = ["--resume", str(run)] if begun else [*words[1:], "--run-dir", str(run)]
                command.main(options.read(argv), shlex.join(["jaxwalk", "train", *argv]))
                if not _has_ended(run):  # Ctrl-C: it stopped where it can go on
                    raise KeyboardInterrupt
            keep(run, name, seed, folder, preset)
