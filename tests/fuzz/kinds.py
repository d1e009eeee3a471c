"""Every kind of file that jaxwalk reads from a user: a valid one, its changes, and who reads it."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jax.numpy as jnp
import mutations
import numpy as np
from hypothesis import strategies as st
from PIL import Image

from jaxwalk import deploy
from jaxwalk.common import files
from jaxwalk.config import Config, DDPGConfig
from jaxwalk.deploy.file import MANIFEST
from jaxwalk.export import manifest, selftest, tensors
from jaxwalk.learn.policies import named, policy, provenance
from jaxwalk.learn.runs import run_folder
from jaxwalk.learn.runs.run_folder import RunFolder
from jaxwalk.measure.compare import policies
from jaxwalk.measure.compare.groups import Entry
from jaxwalk.measure.gait import command as gait
from jaxwalk.measure.gait.options import GaitArgs
from jaxwalk.measure.push_map import table
from jaxwalk.measure.push_map.grid import Grid
from jaxwalk.measure.report import collect, command
from jaxwalk.measure.report.options import ReportArgs
from jaxwalk.measure.report.parts import PARTS

ROOT = Path(__file__).resolve().parents[2]
CONFIG = Config(ddpg=DDPGConfig(hidden=(4, 3)))


@dataclass(frozen=True)
class Kind:
    """One kind of file.

    Attributes:
      path: where a reader looks for it; ``changes`` are written there.
      read: what reads it, and goes on with what it read.
    """

    path: Path
    changes: st.SearchStrategy[bytes]
    read: Callable[[], object]


def small() -> policy.Policy:
    draw = np.random.default_rng(0)
    count = len(CONFIG.observation)
    sizes = {"hidden_0": (count, 4), "hidden_1": (4, 3), "output": (3, 2)}
    actor = {
        name: {"kernel": draw.normal(size=size).astype(np.float32), "bias": np.zeros(size[1], np.float32)}
        for name, size in sizes.items()
    }
    return policy.of_parts(
        CONFIG, actor, jnp.zeros(count), jnp.ones(count),
        clip=5.0, seed=1, command="jaxwalk train", footsteps=7, score=0.5,
    )  # fmt: skip


def walk(path: Path) -> None:
    """The deployed controller, for two ticks: what was read can be used."""
    controller = deploy.Controller.load(path)
    zero = np.zeros((2, 3), np.float32)
    said = deploy.Sensors(1.0, 0.0, 0.05, 0.0, zero, zero, np.array([300.0, 400.0]))
    with np.errstate(all="ignore"):
        controller.start(said, stance=0)
        for _ in range(2):
            assert controller.tick(said).shape == (6,)


def make(folder: Path) -> dict[str, Kind]:
    """All kinds by name; ``folder`` is for their files."""
    trained = small()
    told = manifest.build(trained, CONFIG)
    return {
        **_policies(folder, trained, told),
        **_runs(folder, trained),
        **_maps(folder),
        **_others(folder),
        **_reports(folder / "results"),
    }


def _policies(folder: Path, trained: policy.Policy, told: dict[str, Any]) -> dict[str, Kind]:
    plain, exported, npz = (folder / name for name in ("policy.safetensors", "e.safetensors", "e.npz"))
    policy.save(trained, plain)
    inner = {"jaxwalk_policy": ("config",)}
    both = inner | {MANIFEST: ()}
    whole = tensors.to_safetensors(trained, told)
    return {
        "policy": Kind(
            plain,
            mutations.safetensors_files(plain.read_bytes(), inner),
            lambda: named.load(str(plain)),
        ),
        "exported safetensors": Kind(
            exported, mutations.safetensors_files(whole, both), lambda: walk(exported)
        ),
        "exported npz": Kind(
            npz, mutations.npz_files(tensors.to_npz(trained, told), MANIFEST), lambda: walk(npz)
        ),
    }


def _runs(folder: Path, trained: policy.Policy) -> dict[str, Kind]:
    found = {}
    for name in (run_folder.CONFIG, run_folder.SUMMARY, run_folder.METRICS):
        path = folder / name.partition(".")[0]
        with RunFolder.create(path, CONFIG, 3, "jaxwalk train --seed 3") as run:
            policy.save(trained, run.policy)
        found[name] = path
    record = json.loads((found[run_folder.CONFIG] / run_folder.CONFIG).read_text())
    summary = {"interrupted": True, "footsteps": 7, "seconds": 1.5, "best": {"footsteps": 7, "score": 0.5}}
    rows = "".join(
        files.to_json({"footsteps": i, "seconds": 0.5 * i, "train/reward": None}) + "\n" for i in range(4)
    ).encode()
    row = mutations.texts({"footsteps": 1, "seconds": 0.5}).map(lambda text: rows + text.encode() + b"\n")

    def config() -> None:
        run_folder.load_config(found[run_folder.CONFIG])
        run_folder.load_origin(found[run_folder.CONFIG])

    def metrics() -> None:
        run_folder.read_metrics(found[run_folder.METRICS])
        with RunFolder.reopen(found[run_folder.METRICS]) as run:
            run.keep(3)

    readers = {
        run_folder.CONFIG: (mutations.json_files(record), config),
        run_folder.SUMMARY: (
            mutations.json_files(summary),
            lambda: policies.load([Entry("one", (str(found[run_folder.SUMMARY]),))]),
        ),
        run_folder.METRICS: (st.one_of(row, mutations.contents(rows, rows)), metrics),
    }
    return {name: Kind(found[name] / name, *reader) for name, reader in readers.items()}


def _maps(folder: Path) -> dict[str, Kind]:
    grid, identity = Grid((-40.0, 40.0), (0.0, 0.5), ("torso",), (0.1,), 2, 0), {"policy": "x"}
    table.Table.empty(grid, identity).save(folder)
    path = folder / table.NAME
    return {
        "push map": Kind(
            path,
            mutations.npz_files(path.read_bytes(), "about"),
            lambda: table.resume(folder, grid, identity),
        )
    }


def _others(folder: Path) -> dict[str, Kind]:
    subject = named.load("shipped")
    stamp = provenance.stamp("gait", GaitArgs("shipped", folder), subject, subject.config)
    identity = {name: stamp[name] for name in ("policy_digest", "options", "config")}
    vectors = {"observations": [[0.0, 1.0]] * 3, "actions": [[0.5, 0.5]] * 3, "commands": [[0.6, 0.2]] * 3}
    picture = folder / "map.png"
    Image.new("RGB", (60, 30), "white").save(picture)
    content = picture.read_bytes()
    return {
        "gait report": Kind(
            folder / gait.JSON,
            mutations.json_files(json.loads(files.to_json(stamp))),
            lambda: gait.check_free(folder, identity),
        ),
        "self-test": Kind(
            folder / selftest.VECTORS,
            mutations.json_files(vectors),
            lambda: selftest.vectors(folder / selftest.VECTORS),
        ),
        "picture": Kind(
            picture,
            mutations.contents(content, content),
            lambda: collect._picture(picture, folder / "map.json"),
        ),
    }


def _reports(folder: Path) -> dict[str, Kind]:
    """The results of each command that a report is made of, as they lie in the repository."""
    shutil.copytree(ROOT / "docs" / "results", folder)
    (folder / "bench").mkdir()
    shutil.move(folder / "bench-cpu.json", folder / "bench" / "bench.json")
    subject = named.load("shipped")
    args = ReportArgs("shipped", folder / "page.html", results=folder)
    found = {}
    for part in PARTS.values():
        path = folder / part.command / part.json
        found[f"results of {part.command}"] = Kind(
            path,
            mutations.texts(_short(json.loads(path.read_text()))).map(str.encode),
            lambda part=part: command._figure(part, args, subject),
        )
    return found


def _short(value: Any) -> Any:
    """The same with fewer of what there are many, so that a change meets each kind of value as often."""
    if isinstance(value, dict):
        return {name: _short(one) for name, one in value.items()}
    if isinstance(value, list) and len(value) > 200:
        return value[:3]
    return [_short(one) for one in value] if isinstance(value, list) else value
