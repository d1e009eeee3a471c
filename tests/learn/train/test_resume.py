"""A stopped training goes on bit for bit, whatever stopped it; one that diverges goes back."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest

sys.path.append(str(Path(__file__).parent))

import small

from jaxwalk.common.errors import UserError
from jaxwalk.learn.runs import run_folder
from jaxwalk.learn.runs.progress import Progress
from jaxwalk.learn.runs.run_folder import RunFolder
from jaxwalk.learn.train import device_loop
from jaxwalk.learn.train.run import resume, run


@pytest.fixture(scope="module", autouse=True)
def short():
    with pytest.MonkeyPatch.context() as patch:
        small.shorten(patch.setattr)
        small.undrawn(patch.setattr)
        yield


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """What comes of a run that nothing stops."""
    folder = run(small.CONFIG, tmp_path_factory.mktemp("whole") / "run", small.SEED, small.COMMAND)
    assert not (folder / "resume").exists()  # of no more use
    with pytest.raises(UserError, match="is finished: nothing is left to resume"):
        resume(folder)
    return small.outcome(folder)


def stop_at(patch, report: int, which: int, also=lambda: None) -> None:
    """A signal as the ``report``-th report is shown."""
    shown = []

    def update(*_):
        shown.append(1)
        also()
        if len(shown) == report:
            os.kill(os.getpid(), which)

    patch.setattr(Progress, "update", update)


@pytest.fixture(scope="module")
def stopped_once(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        stop_at(patch, 3, signal.SIGINT)
        return run(small.CONFIG, tmp_path_factory.mktemp("once") / "a", small.SEED, small.COMMAND)


@pytest.fixture
def stopped(stopped_once, tmp_path):
    """A run that SIGINT ended at its third report."""
    return shutil.copytree(stopped_once, tmp_path / "stopped")


def kill(process: subprocess.Popen[str]) -> None:
    process.kill()  # SIGKILL
    process.communicate()


def test_killed_while_a_checkpoint_is_written(whole, tmp_path):
    folder = tmp_path / "run"
    process = small.start(folder)
    # Orbax writes into a folder of this name first; one whole checkpoint at least is there before.
    while process.poll() is None:
        names = os.listdir(folder / "resume") if (folder / "resume").exists() else []
        if any(name.isdigit() for name in names) and any("tmp" in name for name in names):
            break
        time.sleep(0.0005)
    assert process.poll() is None, process.communicate()
    kill(process)
    with (folder / "metrics.jsonl").open("a") as file:
        file.write('{"footsteps": 12')  # as a kill within a write leaves it
    resume(folder)
    assert small.outcome(folder) == whole


@pytest.mark.parametrize("report, which", [(1, signal.SIGTERM), (5, signal.SIGINT)])
def test_stopped_by_a_signal_and_by_clocks_that_jump(whole, tmp_path, monkeypatch, report, which):
    with monkeypatch.context() as patch:
        # By minutes: Orbax, which waits ten of them for a write, counts these by the same clock.
        draw, now = random.Random(1), time.time
        patch.setattr(time, "time", lambda: now() + draw.uniform(-120, 120))
        stop_at(patch, report, which)
        folder = run(small.CONFIG, tmp_path / "run", small.SEED, small.COMMAND)
        assert run_folder.read_summary(folder)["interrupted"]
        kept = len(run_folder.read_metrics(folder))
        patch.setattr(Progress, "update", lambda *_: None)
        resume(folder)
    assert small.outcome(folder) == whole
    seconds = [row["seconds"] for row in run_folder.read_metrics(folder)]
    assert seconds == sorted(seconds) and seconds[kept] - seconds[kept - 1] < 600


def test_a_damaged_checkpoint_costs_no_more_than_the_way_from_the_one_before(whole, stopped, capsys):
    _, last = sorted((stopped / "resume").iterdir(), key=lambda path: int(path.name))
    (data,) = [path for path in (last / "rest").iterdir() if path.name == "metadata"]
    data.write_bytes(data.read_bytes()[:100])
    resume(stopped)
    assert f"checkpoint {last.name} is damaged" in capsys.readouterr().out
    assert small.outcome(stopped) == whole


def test_without_a_usable_checkpoint_nothing_is_touched(stopped):
    metrics = (stopped / "metrics.jsonl").read_bytes()
    for path in (stopped / "resume").iterdir():
        shutil.rmtree(path / "arrays")
    with pytest.raises(UserError, match=r"no checkpoint in .* can be used"):
        resume(stopped)
    shutil.rmtree(stopped / "resume")
    with pytest.raises(UserError, match="holds no checkpoint"):
        resume(stopped)
    assert (stopped / "metrics.jsonl").read_bytes() == metrics
    assert run_folder.read_summary(stopped)["interrupted"]


def test_metrics_that_lack_rows_are_not_gone_on_with(stopped):
    file = stopped / "metrics.jsonl"
    text = file.read_text().splitlines(keepends=True)[0]
    file.write_text(text)
    with pytest.raises(UserError, match="has 1 lines, its checkpoint knows 4"):
        resume(stopped)
    assert file.read_text() == text


def test_a_run_of_another_trainer_is_refused(stopped):
    file = stopped / "config.json"
    before = {path: path.read_bytes() for path in stopped.glob("*.*") if path != file}
    file.write_text(json.dumps(json.loads(file.read_text()) | {"command": "jaxwalk train-baseline sac"}))
    with pytest.raises(UserError, match="was begun by 'jaxwalk train-baseline sac'"):
        resume(stopped)
    file.write_text(json.dumps({"config": json.loads(file.read_text())["config"], "seed": "one"}))
    with pytest.raises(UserError, match="lacks seed, command or versions"):
        resume(stopped)
    assert {path: path.read_bytes() for path in before} == before


def test_one_process_at_a_time(stopped):
    before = (stopped / "metrics.jsonl").read_bytes()
    with RunFolder.reopen(stopped), pytest.raises(UserError, match="in use by another jaxwalk"):
        resume(stopped)
    assert (stopped / "metrics.jsonl").read_bytes() == before


def test_killed_before_the_first_checkpoint_it_begins_anew(whole, tmp_path):
    with RunFolder.create(tmp_path / "run", small.CONFIG, small.SEED, small.COMMAND) as folder:
        folder.log({"footsteps": 0, "seconds": 1.0})
    resume(folder.path)
    assert small.outcome(folder.path) == whole


@contextlib.contextmanager
def disk(path: Path, size: str):
    """A file system of its own. Skips where that is not allowed."""
    path.mkdir()
    made = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", path], capture_output=True)
    if made.returncode:
        pytest.skip("file systems are mounted by the superuser only")
    try:
        yield lambda options: subprocess.run(["mount", "-o", f"remount,{options}", path], check=True)
    finally:
        subprocess.run(["umount", "-l", path], check=True)


def test_a_full_disk(whole, tmp_path):
    with disk(tmp_path / "disk", "64m") as remount:
        path = tmp_path / "disk" / "run"
        filling = []

        def fill(*_):
            filling.append(1)
            if len(filling) == 4:
                with contextlib.suppress(OSError), open(tmp_path / "disk" / "large", "wb", 0) as file:
                    while file.write(bytes(4096)):
                        pass

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(Progress, "update", fill)
            with pytest.raises(UserError, match=f"(?i)no space left.*make room.*--resume {path}"):
                run(small.CONFIG, path, small.SEED, small.COMMAND)
        remount("size=128m")
        resume(path)
        assert small.outcome(path) == whole


def test_a_read_only_disk(stopped, whole, tmp_path):
    with disk(tmp_path / "disk", "64m") as remount:
        path = shutil.copytree(stopped, tmp_path / "disk" / "run")
        remount("ro")
        with pytest.raises(UserError, match=r"cannot write the run folder .*Read-only"):
            resume(path)
        remount("rw")
        resume(path)
        assert small.outcome(path) == whole


def test_out_of_memory_names_what_to_lower(tmp_path, monkeypatch):
    # A petabyte, asked of the machine for real.
    monkeypatch.setattr(device_loop, "init", lambda *_: jnp.zeros(2**48).block_until_ready())
    with pytest.raises(UserError, match=r"out of memory.*--train\.walkers 8 .*--ddpg\.replay-capacity 2048"):
        run(small.CONFIG, tmp_path / "run", 0, "jaxwalk train")


def test_a_training_that_diverges_goes_back_and_in_the_end_stops(tmp_path, capsys):
    wild = dataclasses.replace(
        small.CONFIG,
        # One step so long that the critic's values overflow; all updates after it are skipped.
        ddpg=dataclasses.replace(small.CONFIG.ddpg, critic_lr=1e37, max_grad_norm=0.0, critic_head_start=0),
        train=dataclasses.replace(
            small.CONFIG.train, footsteps=10_000, divergence_limit=3, divergence_events=2
        ),
    )
    path = tmp_path / "run"
    with pytest.raises(UserError, match=r"diverged at .* footsteps, time 2.*--ddpg\.critic-lr.*--resume"):
        run(wild, path, 1, "jaxwalk train")
    assert "training goes back" in capsys.readouterr().out
    summary, rows = run_folder.read_summary(path), run_folder.read_metrics(path)
    events = [row for row in rows if "divergence/back_to" in row]
    assert [row["divergence/back_to"] for row in events] == [one["back_to"] for one in summary["divergences"]]
    assert len(events) == 2 and all(row["divergence/skipped"] > 3 for row in events)
    reports = [row for row in rows if "train/reward" in row]
    assert all(np.isfinite(row["learner/critic_loss"]) for row in reports)
    # What it leaves behind shows the last one again.
    first = small.outcome(path)
    with pytest.raises(UserError, match=r"diverged at .* footsteps, time 2"):
        resume(path)
    assert small.outcome(path) == first
    assert json.loads((path / "config.json").read_text())["seed"] == 1


@pytest.mark.slow
def test_killed_twenty_times_at_random_moments(whole, tmp_path):
    folder, draw = tmp_path / "run", random.Random(0)
    kills, process = 0, small.start(folder)
    while kills < 20:
        # Anywhere from the interpreter's start to the last report.
        begun, wait = time.monotonic(), draw.uniform(0, 2)
        rows = draw.randrange(2, 11) if kills % 4 else 0
        while process.poll() is None and time.monotonic() - begun < 300:
            file = folder / "metrics.jsonl"
            if file.exists() and len(file.read_bytes().splitlines()) >= rows:
                break
            time.sleep(0.001)
        time.sleep(wait * (kills % 4 == 0) + wait / 100)
        kill(process)
        kills += 1
        if not (folder / "config.json").exists():
            process = small.start(folder)
        elif run_folder.read_summary(folder):
            assert small.outcome(folder) == whole
            shutil.rmtree(folder)
            process = small.start(folder)
        else:
            process = small.start(folder, resume=True)
    kill(process)
    if not run_folder.read_summary(folder):
        resume(folder)
    assert small.outcome(folder) == whole
