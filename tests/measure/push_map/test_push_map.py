"""``jaxwalk push-map`` from the outside: whole, in pieces, and interrupted."""

from __future__ import annotations

import contextlib
import json
import os
import resource
import subprocess
import sys

import jax
import numpy as np
import pytest

from jaxwalk import cli
from jaxwalk.common.parallel import devices
from jaxwalk.measure.evaluate import evaluation
from jaxwalk.measure.push_map import run, table
from jaxwalk.task import backend

OPTIONS = "--impulses -10,10,400 --phases 2 --replicas 2".split()


@pytest.fixture(scope="module", autouse=True)
def short():
    """Few unpushed walkers and short trials: their statistics are not looked at here."""
    mesh = devices.mesh
    with pytest.MonkeyPatch.context() as patch:
        # Two devices at most: a block for each of many would make one chunk of all 12 trials.
        patch.setattr(devices, "mesh", lambda *_: mesh(2))
        for one in (devices, backend):
            patch.setattr(one, "BLOCK", 2)  # so that few trials make several chunks
        patch.setattr(run, "CALM", 4)
        patch.setattr(run, "CALM_SECONDS", 6.0)
        patch.setattr(evaluation, "AFTER_PUSH", 2.0)
        yield


def push_map(out, *more):
    return cli.main(["push-map", "replan", "--out", str(out), *OPTIONS, *more])


def trials(out):
    with np.load(out / table.NAME) as stored:
        return {name: stored[name] for name in (*table.RESULTS, "impulse", "phase", "point", "done")}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    out = tmp_path_factory.mktemp("map") / "deep" / "folder"
    assert push_map(out, "--chunk", "12") == 0
    return out


def test_everything_is_written(whole):
    assert sorted(p.name for p in whole.iterdir()) == ["map.json", "map.npz", "map.png"]
    found = trials(whole)
    assert found["done"].all() and len(found["done"]) == 12
    np.testing.assert_allclose(found["impulse_delivered"][:8], found["impulse"][:8], rtol=1e-4)


def test_mild_pushes_are_survived_and_a_huge_one_is_not(whole):
    result = json.loads((whole / "map.json").read_text())
    part = result["maps"][0][0]
    assert part["survival"] == [[1, 1], [1, 1], [0, 0]]
    assert part["threshold"]["worst_phase"]["forward"] == {
        "impulse": 10.0, "per_kg": pytest.approx(10 / 75, rel=1e-4), "censored": False,
    }  # fmt: skip
    assert part["threshold"]["worst_phase"]["backward"]["censored"]
    pendulum = result["pendulum"]
    assert 0.8 < pendulum["height"] < 1.1 and pendulum["mass"] == pytest.approx(75, rel=1e-4)
    assert pendulum["shortest"] <= pendulum["seconds"] + 0.1
    fallen = trials(whole)["fall_seconds"][8:]
    assert (fallen > 0).all() and (fallen < 2).all()


@contextlib.contextmanager
def no_room():
    """No file of this process may be longer than 64 bytes: a write fails as on a full disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (64, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def test_a_map_in_pieces_and_interrupted_is_the_same_map(whole, tmp_path, monkeypatch, capsys):
    saves, save = [], table.Table.save

    def hampered(self, folder):
        saves.append(int(self.done.sum()))
        if len(saves) == 4:
            raise KeyboardInterrupt
        with no_room() if len(saves) == 2 else contextlib.nullcontext():
            save(self, folder)

    monkeypatch.setattr(table.Table, "save", hampered)
    capsys.readouterr()
    assert push_map(tmp_path, "--chunk", "4") == 2
    error = capsys.readouterr().err
    assert f"cannot write {tmp_path / table.NAME}" in error and error.count("\n") == 1
    assert [p.name for p in tmp_path.iterdir()] == [table.NAME]  # nor anything half written
    assert trials(tmp_path)["done"].sum() == saves[0] < 12  # the first chunk is kept
    assert push_map(tmp_path, "--chunk", "4") == 130
    assert trials(tmp_path)["done"].sum() == saves[2]  # the second one too
    assert push_map(tmp_path, "--chunk", "4") == 0
    assert saves[0] < saves[1] == saves[2] and saves[-1] == 12  # what was lost is done again, no more
    got = trials(tmp_path)
    for name, column in trials(whole).items():
        np.testing.assert_array_equal(got[name], column, err_msg=name)


def test_one_device_or_two_make_the_same_map(whole, tmp_path):
    other = 1 if jax.device_count() > 1 else 2
    program = f"""
import sys
from jaxwalk import cli
from jaxwalk.common.parallel import devices
from jaxwalk.measure.evaluate import evaluation
from jaxwalk.task import backend
from jaxwalk.measure.push_map import run
devices.BLOCK = backend.BLOCK = {backend.BLOCK}
run.CALM, run.CALM_SECONDS, evaluation.AFTER_PUSH = {run.CALM}, {run.CALM_SECONDS}, {evaluation.AFTER_PUSH}
sys.exit(cli.main(["push-map", "replan", "--out", {str(tmp_path)!r}, *{OPTIONS!r}, "--chunk", "12"]))
"""
    flags = [f for f in os.environ.get("XLA_FLAGS", "").split() if "host_platform_device_count" not in f]
    told = {"JAX_NUM_CPU_DEVICES": str(other), "JAX_PLATFORMS": "cpu", "XLA_FLAGS": " ".join(flags)}
    subprocess.run([sys.executable, "-c", program], check=True, env=os.environ | told)
    assert len(json.loads((tmp_path / "map.json").read_text())["hardware"]["devices"]) == other
    got, expected = trials(tmp_path), trials(whole)
    for name, column in expected.items():
        np.testing.assert_array_equal(got[name], column, err_msg=name)


def test_pushes_on_the_legs(tmp_path):
    """Each point makes another walk of the same start, and only the torso has a pendulum's limits."""
    legs = "torso,stance-shank,swing-thigh,swing-shank"
    assert push_map(tmp_path, "--points", legs, "--chunk", "48") == 0
    found, result = trials(tmp_path), json.loads((tmp_path / "map.json").read_text())
    assert found["point"].tolist() == np.repeat(legs.split(","), 12).tolist()
    mild = np.abs(found["impulse"]) == 10
    np.testing.assert_allclose(found["impulse_delivered"][mild], found["impulse"][mild], rtol=1e-4)
    assert result["points"] == legs.split(",")
    limited = [part["limits"] is not None for part in result["maps"][0]]
    assert limited == [True, False, False, False]
    steps = {found["longest"].reshape(4, -1)[row, :8].tobytes() for row in range(4)}
    assert len(steps) == 4  # of the walkers that stay up


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--impulses", "10,-10"], "--impulses 10,-10: give ascending"),
        (["--impulses", ""], "no list of impulses"),
        (["--points", "torso,torso+0"], "--points torso,torso: give each point once"),
        (["--points", "torso+7"], "--points torso 7: give -1 to 1 m"),
        (["--points", "torso,left-thigh"], "'left-thigh' is no point on the body"),
        (["--points", ""], "'' is no point on the body"),
        (["--durations", "0"], "--durations 0"),
        (["--chunk", "0"], "--chunk 0: give a whole number"),
    ],
)
def test_bad_options_are_one_line(options, said, tmp_path, capsys):
    assert cli.main(["push-map", "replan", "--out", str(tmp_path / "m"), *options]) == 2
    error = capsys.readouterr().err
    assert said in error and error.count("\n") == 1
    assert not (tmp_path / "m").exists()


@pytest.mark.parametrize("other", [["--seed", "1"], ["--engine", "mujoco"]], ids=" ".join)
def test_another_map_is_not_overwritten(whole, capsys, other):
    before = (whole / table.NAME).read_bytes()
    assert push_map(whole, *other) == 2
    assert "another policy, grid, seed or engine" in capsys.readouterr().err
    assert (whole / table.NAME).read_bytes() == before


@pytest.mark.parametrize("content", [b"", b"junk", b"PK\x03\x04 cut short"])
def test_a_damaged_map_is_one_line(content, tmp_path, capsys):
    (tmp_path / table.NAME).write_bytes(content)
    assert push_map(tmp_path) == 2
    error = capsys.readouterr().err
    assert "map.npz: not a whole zip file; give --out another folder" in error and error.count("\n") == 1
