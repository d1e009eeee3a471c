"""``jaxwalk push-map`` from its options to its files."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table as Screen

from jaxwalk.common import files, runtime
from jaxwalk.config import to_dict
from jaxwalk.learn.policies import named, provenance
from jaxwalk.learn.policies.named import Subject
from jaxwalk.measure.push_map import picture, run, summary, table
from jaxwalk.measure.push_map.capturability import Pendulum
from jaxwalk.measure.push_map.grid import Grid
from jaxwalk.model import anthropometry, physics
from jaxwalk.task import backend
from jaxwalk.task.trials import Trial

if TYPE_CHECKING:
    from jaxwalk.measure.push_map.options import PushMapArgs


def push_map(subject: Subject, args: PushMapArgs, progress: Progress) -> dict[str, Any]:
    """Try the whole grid and write ``map.npz``, ``map.json`` and ``map.png``; gives the JSON."""
    args = backend.sized(args, subject.config, many=64, few=8)
    phases = tuple(i / args.phases for i in range(args.phases))
    grid = Grid(args.impulses, phases, args.points, args.durations, args.replicas or 0, args.seed)
    identity = {"policy": subject.digest, "config": to_dict(subject.config), "engine": args.engine}
    identity |= runtime.versions()
    found = table.resume(args.out, grid, identity)
    files.make_folder("--out", args.out)
    before = int(found.done.sum())
    bar = progress.add_task(f"{grid.size:,} trials", total=1.0)
    walked, rate = run.run(
        subject,
        args.engine,
        found,
        args.chunk,
        args.out,
        lambda share: progress.update(bar, completed=share),
    )
    result = summary.summarise(found, _pendulum(subject, walked, found)) | {
        "resumed_trials": before,
        "ticks_per_second": rate or None,
        **provenance.stamp("push-map", args, subject, subject.config),
    }
    files.write_json(args.out / "map.json", result)
    title = f"{args.policy}, {args.engine}: {grid.replicas} walkers a cell, {grid.size:,} trials"
    picture.draw(result, title, args.out / "map.png")
    return result


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
    """The command."""
    subject = named.load(args.policy, model=args.model)
    console = Console()
    backend.begin(subject.config, args.engine)
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.percentage:.0f} %"))
    with Progress(
        *columns, TimeRemainingColumn(), console=console, disable=not console.is_terminal
    ) as progress:
        result = push_map(subject, args, progress)
    title = f"{args.policy}, {result['replicas']} walkers a cell"
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
    console.print(f"map.npz, map.json and map.png in {args.out}", highlight=False)


def _told(threshold: dict[str, Any] | None) -> str:
    if threshold is None:
        return "-"
    more = " or more: the grid ends" if threshold["censored"] else ""
    return f"{threshold['impulse']:g} N s ({threshold['per_kg']:.2f} N s/kg){more}"
