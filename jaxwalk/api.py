"""What a program calls; ``import jaxwalk as jw`` offers these names. The commands call the same functions.

They may be called from a thread, from a notebook, and from a process that has computed with JAX before, whose
number of CPU devices then stays what it was.
"""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from jaxwalk import deploy
from jaxwalk.common.errors import UserError
from jaxwalk.config import Actuators, BodyModel, Config, Engine, of_dict, to_dict, validate
from jaxwalk.config.presets import PRESETS
from jaxwalk.export import command as _export
from jaxwalk.learn.policies import named
from jaxwalk.learn.policies.named import Subject
from jaxwalk.learn.train import command as _train
from jaxwalk.learn.train import multi_seed
from jaxwalk.learn.train import run as _run
from jaxwalk.measure.evaluate import evaluation
from jaxwalk.measure.protocol import PushTest
from jaxwalk.measure.push_map import command as _map
from jaxwalk.measure.push_map.options import PushMapArgs
from jaxwalk.options import arguments, checks
from jaxwalk.options.arguments import looked_at
from jaxwalk.task.env import FootstepEnv

Controller = deploy.Controller
AnyPath = str | PathLike[str]


@looked_at
def preset(name: str = "default") -> Config:
    """A named configuration; change it by ``dataclasses.replace``.

    Raises:
      UserError: no preset of that name.
    """
    if name not in PRESETS:
        raise UserError(f"no preset {name!r}: give one of {', '.join(PRESETS)}")
    return PRESETS[name]


@looked_at
def train(config: Config, run_dir: AnyPath | None = None, *, seed: int = 0, seeds: int = 1) -> Path:
    """Train a policy into a run folder, and return the folder.

    Ctrl-C in the main thread ends after the report under way, and keeps the best policy so far.

    Args:
      run_dir: new, or without a run in it; None: a name of its own under ``runs``.
      seed: of everything that is drawn at random. seeds: so many trainings in one program, from ``seed`` on;
        the folder then holds a run folder for each.

    Raises:
      UserError: a configuration without sense, a folder that cannot be used, a full disk or memory, or a
        training that diverges again and again.
    """
    validate.check(of_dict(to_dict(config)))  # types, too
    checks.between("--seeds", seeds, 1, 1024, ", each a training of its own")
    for end in (seed, seed + seeds - 1):
        checks.seed(end)
    folder = None if run_dir is None else Path(run_dir)
    typed = f"jaxwalk.train(config, {run_dir and fspath(run_dir)!r}, seed={seed}, seeds={seeds})"
    if seeds > 1:
        return multi_seed.run_many(config, folder, seed, seeds, typed)
    return _run.run(config, folder, seed, typed)


@looked_at
def resume(run_dir: AnyPath) -> Path:
    """Go on with a training that was stopped, bit for bit, and return its folder.

    Raises:
      UserError: there is no run to go on with; or as `train`.
    """
    return _train.resume(Path(run_dir))


@looked_at
def load_policy(
    name: AnyPath = "shipped",
    *,
    speed: float | None = None,
    height: float | None = None,
    mass: float | None = None,
    noise: float | None = None,
    model: BodyModel | None = None,
    actuators: Actuators | None = None,
) -> Subject:
    """A policy, with the configuration that it acts under.

    Args:
      name: a run folder, a policy file, ``shipped``, ``shipped-rigid``, or a rule: ``fixed``, ``constant``,
        ``raibert``, ``capture-point``, ``replan``.
      speed: to aim at, m/s. height: m. mass: kg. noise: scale of the sensors'. model: of the body.
        actuators: whose strength the joints have. None leaves what the policy was trained with.

    Raises:
      UserError: no such policy, a damaged one, or a value out of range.
    """
    checks.policy(fspath(name))
    if speed is not None:
        checks.between("--speed", speed, 0.1, 3.0, " m/s")
    if noise is not None:
        checks.between("--noise", noise, 0.0, 100.0, "")
    changes = dict(height=height, mass=mass, noise=noise)
    return named.load(fspath(name), speed=speed, model=model, actuators=actuators, **changes)


@looked_at
def evaluate(policy: Subject | AnyPath = "shipped", test: PushTest | None = None) -> dict[str, Any]:
    """Does it walk, which pushes does it survive, how soon is it steady again.

    Args:
      policy: of `load_policy`, or what that takes.
      test: what it is put through; default: ``PushTest()``.

    Returns:
      ``walking``, and where there are pushes ``pushes``, ``threshold`` and ``threshold_worst_phase`` (N s);
      between walls ``walls``. Plain numbers and lists, see `evaluation.Walking` and `evaluation.Pushes`;
      ``jaxwalk evaluate --json`` writes them with a stamp of their origin.

    Raises:
      UserError: no such policy, or a value of ``test`` that is out of range.
    """
    test = test or PushTest()
    arguments.check_fields(test)
    test.check()
    return evaluation.evaluate(_subject(policy), test)


@looked_at
def push_map(
    policy: Subject | AnyPath,
    out: AnyPath,
    *,
    impulses: Sequence[float] = PushMapArgs.impulses,
    phases: int = PushMapArgs.phases,
    points: Sequence[str] = PushMapArgs.points,
    durations: Sequence[float] = PushMapArgs.durations,
    replicas: int | None = None,
    engine: Engine = "mjx",
    seed: int = 0,
) -> dict[str, Any]:
    """Which pushes a policy survives: phase of the step x impulse x point x duration.

    Args:
      out: folder for ``map.npz``, which an interrupted map goes on from.
      impulses: N s, ascending, forward positive. phases: of the step, evenly spread.
      points: of the body, see `jaxwalk.model.push_points`. durations: s, ascending.
      replicas: walkers for each combination; None: as many as the machine makes light of.
      engine: what moves them. seed: of starts and noise.

    Returns:
      What ``map.json`` holds but for the stamp of its origin: plain numbers and lists.

    Raises:
      UserError: a value out of range, the policy does not walk, or ``out`` holds another map or cannot be
        written.
    """
    subject = _subject(policy)
    args = PushMapArgs(
        "fixed",  # who walks is known already
        Path(out),
        tuple(map(float, impulses)),
        phases,
        tuple(points),
        tuple(map(float, durations)),
        replicas,
        engine=engine,
        seed=seed,
    )
    args.check()
    return _map.push_map(subject, _map.grid_of(args, subject), args.out, engine)


@looked_at
def export_policy(
    policy: Subject | AnyPath, out: AnyPath, *, formats: tuple[str, ...] = ("safetensors",)
) -> dict[str, Path]:
    """Write a trained policy with its controllers for other runtimes; the files, by format.

    Args:
      out: folder, made if it is not there.
      formats: of safetensors, npz, onnx, stablehlo, c.

    Raises:
      UserError: a rule that nobody trained, a policy that `load_policy` changed, an unknown format, or a
        folder that cannot be written.
    """
    if not formats or not set(formats) <= set(_export.WRITERS):
        raise UserError(f"formats {formats!r}: give a tuple of some of {', '.join(_export.WRITERS)}")
    name = policy.name if isinstance(policy, Subject) else fspath(policy)
    checks.policy(name)
    if isinstance(policy, Subject) and policy.config != named.load(name).config:
        raise UserError(f"policy {name} was changed when it was loaded: export it as it was trained")
    return _export.write(*_export.load(name), tuple(formats), Path(out))


def _subject(policy: Subject | AnyPath) -> Subject:
    return policy if isinstance(policy, Subject) else load_policy(policy)


__all__ = [
    "Config",
    "Controller",
    "FootstepEnv",
    "PushTest",
    "Subject",
    "UserError",
    "evaluate",
    "export_policy",
    "load_policy",
    "preset",
    "push_map",
    "resume",
    "train",
]
