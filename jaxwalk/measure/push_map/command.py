"""``jaxwalk push-map`` from its options to its files."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
from rich.console import Console
from rich.table import Table as Screen

from jaxwalk.common import files, runtime
from jaxwalk.config import Engine, to_dict
from jaxwalk.learn.policies import named
from jaxwalk.learn.policies.named import Subject
from jaxwalk.measure import study
from jaxwalk.measure.push_map import picture, run, summary, table
from jaxwalk.measure.push_map.capturability import Pendulum
from jaxwalk.measure.push_map.grid import Grid
from jaxwalk.measure.screen import OnProgress
from jaxwalk.model import anthropometry, physics
from jaxwalk.task import backend
from jaxwalk.task.trials import Trial

if TYPE_CHECKING:
    from jaxwalk.measure.push_map.options import PushMapArgs

REPLICAS = 64, 8  # walkers for each cell: by native code, and elsewhere


def grid_of(args: PushMapArgs, subject: Subject) -> Grid:
    """What is tried, with as many replicas as the machine makes light of where none are asked for."""
    replicas = backend.sized(args, subject.config, *REPLICAS).replicas or 0
    return Grid.even(args.impulses, args.phases, args.points, args.durations, replicas, args.seed)


def push_map(
    subject: Subject,
    grid: Grid,
    out: Path,
    engine: Engine = "mjx",
    chunk: int = 512,
    progress: OnProgress = lambda what, share: None,
) -> dict[str, Any]:
    """Try the whole grid; ``map.npz`` in ``out`` is kept up to date, and what it holds is not tried again.

    Args:
      chunk: trials in one program, at most.

    Raises:
      UserError: the policy does not walk, or ``out`` holds another map or cannot be written.
    """
    identity = {"policy": subject.digest, "config": to_dict(subject.config), "engine": engine}
    found = table.resume(out, grid, identity | runtime.versions())
    files.make_folder("--out", out)
    before, what = int(found.done.sum()), f"{grid.size:,} trials"
    walked, rate = run.run(subject, engine, found, chunk, out, lambda share: progress(what, share))
    pendulum = _pendulum(subject, walked, found)
    return summary.summarise(found, pendulum) | {"resumed_trials": before, "ticks_per_second": rate or None}


def _pendulum(subject: Subject, walked: Trial, found: table.Table) -> Pendulum:
    """The walker as a pendulum: its own height of the centre of mass, step, and abilities."""
    config, tally = subject.config, walked.tally
    person = anthropometry.build(config.body)
    model = physics.compile_mujoco(config.body, config.physics)
    data = mujoco.MjData(model)
    data.qpos[1] = person.hip_height
    mujoco.mj_forward(model, data)
    steps = max(float(tally.steps.sum()), 1.0)
    step, seconds = float(tally.step_length.sum()) / steps, float(tally.step_seconds.sum()) / steps
    longest, shortest = summary.abilities(found)
    return Pendulum(
        height=float(data.subtree_com[1, 2]),
        mass=float(np.sum(model.body_mass)),
        step=step,
        seconds=seconds,
        longest=longest or step,
        shortest=shortest or seconds,
        half_foot=person.toe,
    )


def main(args: PushMapArgs) -> None:
    """Run ``jaxwalk push-map``."""
    subject = named.load(args.policy, model=args.model, actuators=args.actuators)
    grid = grid_of(args, subject)
    args = dataclasses.replace(args, replicas=grid.replicas)
    title = f"{args.policy}, {args.engine}: {grid.replicas} walkers a cell, {grid.size:,} trials"
    study.carry_out(
        "push-map",
        args,
        subject.config,
        subject,
        lambda progress: push_map(subject, grid, args.out, args.engine, args.chunk, progress),
        lambda console, result: _print(console, args.policy, result),
        lambda result: picture.draw(result, title),
        stem="map",
        also="map.npz",
    )


def _print(console: Console, name: str, result: dict[str, Any]) -> None:
    title = f"{name}, {result['replicas']} walkers a cell"
    screen = Screen("push", "all phases", "worst phase", "least share of the limit", title=title)
    for d, duration in enumerate(result["durations"]):
        for point, part in zip(result["points"], result["maps"][d], strict=True):
            for way in ("forward", "backward"):
                name = f"{way}, {duration:g} s, {point}"
                told = [_told(part["threshold"][which][way]) for which in ("all_phases", "worst_phase")]
                limited = part["share_of_limit"] or {way: []}
                shares = [share for share in limited[way] if share is not None]
                screen.add_row(name, *told, f"{min(shares):.2f}" if shares else "-")
    console.print(screen)


def _told(threshold: dict[str, Any] | None) -> str:
    if threshold is None:
        return "-"
    more = " or more: the grid ends" if threshold["censored"] else ""
    return f"{threshold['impulse']:g} N s ({threshold['per_kg']:.2f} N s/kg){more}"
