"""Real processes over loopback: what they make together is what one device makes alone, and how they end."""

from __future__ import annotations

import contextlib
import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest

sys.path.append(str(Path(__file__).parent))

import small

from jaxwalk import cli
from jaxwalk.common.errors import UserError
from jaxwalk.common.parallel.launch import LOST, Place, joined
from jaxwalk.learn.policies import policy
from jaxwalk.learn.runs import run_folder

LIMIT = 900  # s; two cold compilations side by side, on a machine that is shared
PARAMETERS = 1e-5  # largest difference of a parameter of the policy, after some twenty updates
ROWS = 1e-2  # of the metrics: a walker's mean speed over a footstep, say


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return server.getsockname()[1]


@contextlib.contextmanager
def pair(folder: Path, resume: bool = False) -> Iterator[list[subprocess.Popen[str]]]:
    """Two processes of two devices each; none outlives the test."""
    coordinator = f"127.0.0.1:{free_port()}"
    both = [small.start(folder, resume, 2, Place(coordinator, 2, which)) for which in range(2)]
    try:
        yield both
    finally:
        for process in both:
            process.kill()
            process.wait()


def ended(process: subprocess.Popen[str], code: int = 0) -> str:
    said, _ = process.communicate(timeout=LIMIT)
    assert process.returncode == code, said
    return said


def until_evaluated(folder: Path) -> list[dict[str, Any]]:
    """The rows up to the second evaluation. Landings enlarge rounding: in time walks part."""
    rows = run_folder.read_metrics(folder)
    _, second, *_ = [i for i, row in enumerate(rows) if "eval/score" in row]
    return rows[: second + 1]


def alike(one: Path, other: Path) -> None:
    """The same footsteps, evaluations and policy, but for what rounding does."""
    rows, others = until_evaluated(one), until_evaluated(other)
    assert [row["footsteps"] for row in rows] == [row["footsteps"] for row in others]
    for row, twin in zip(rows, others, strict=True):
        assert row.keys() == twin.keys()
        for name in row.keys() - small.CLOCKED:
            assert twin[name] == pytest.approx(row[name], rel=ROWS, abs=ROWS), name
    name = f"{rows[-1]['footsteps']:09d}.safetensors"
    left, right = (policy.load(folder / run_folder.CHECKPOINTS / name) for folder in (one, other))
    for a, b in zip(jax.tree.leaves(left), jax.tree.leaves(right), strict=True):
        np.testing.assert_allclose(a, b, rtol=0, atol=PARAMETERS)
    assert rows[-2]["learner/updates"] > 10  # there was something to differ in
    assert not run_folder.read_summary(other)["interrupted"]


_SETTLE = """
import sys
import numpy as np
from jaxwalk.common import runtime
from jaxwalk.common.errors import UserError
from jaxwalk.common.parallel import collectives, launch
runtime.setup()
which = int(sys.argv[2])
with launch.joined(launch.Place(sys.argv[1], 2, which), "go on"):
    assert collectives.broadcast(lambda: f"from {which}") == "from 0"
    assert collectives.any_process(which == 1, which == 2) == (True, False)
    mine = collectives.share(5)
    rows = {"x": np.float32(mine) / 7, "up": mine % 2 == 0, "o": np.stack([mine, -mine], axis=1)}
    got = collectives.gather(rows)
    every = np.arange(6) % 5
    assert got["x"].tobytes() == (np.float32(every) / 7).tobytes()
    assert got["up"].tolist() == (every % 2 == 0).tolist()
    assert got["o"].tolist() == np.stack([every, -every], axis=1).tolist()
    def wrong():
        raise UserError("nothing here")
    collectives.broadcast(wrong)
"""


def test_processes_settle_what_one_knows_and_end_with_what_one_finds_wrong():
    coordinator = f"127.0.0.1:{free_port()}"
    both = [
        subprocess.Popen(
            [sys.executable, "-c", _SETTLE, coordinator, str(which)],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            env=os.environ | {"JAX_NUM_CPU_DEVICES": "2"},
        )
        for which in range(2)
    ]
    said, silence = ended(both[0], 1), ended(both[1], 2)  # 1: no command here that makes a line of it
    assert "Agreed: nothing here" in said
    assert "nothing here" not in silence and "Traceback" not in silence


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """The run on one device."""
    folder = tmp_path_factory.mktemp("alone") / "run"
    ended(small.start(folder, devices=1))
    return folder


@pytest.mark.slow
def test_two_processes_of_two_devices_train_as_one_device_does(alone, tmp_path):
    folder = tmp_path / "run"
    with pair(folder) as (first, second):
        said, silence = ended(first), ended(second)
    assert "4 of 2 processes" in said and "done: best policy" in said
    assert "run folder" not in silence and "evaluation" not in silence  # one tells for both
    assert len(list(folder.glob("events.out*"))) == 1
    alike(alone, folder)


@pytest.mark.slow
@pytest.mark.parametrize("which", [0, 1])
def test_a_process_that_is_killed_ends_the_other_and_the_run_goes_on_elsewhere(alone, tmp_path, which):
    folder = tmp_path / "run"
    with pair(folder) as both:
        assert both[0].stdout is not None
        for line in both[0].stdout:
            if line.startswith("evaluation") and " 0 footsteps" not in line:
                break
        both[which].kill()
        said, _ = both[1 - which].communicate(timeout=60)
    assert both[1 - which].returncode == LOST
    assert said.count("has gone (see its own output); go on") == 1
    assert f"process {which}" in said and "Traceback" not in said and "@ " not in said
    if which:  # on one device
        ended(small.start(folder, resume=True, devices=1))
    else:  # on as many as before
        with pair(folder, resume=True) as again:
            assert "resumed at" in ended(again[0])
            ended(again[1])
    alike(alone, folder)


@pytest.mark.slow
def test_what_was_begun_on_one_device_goes_on_in_two_processes(alone, tmp_path):
    folder = tmp_path / "run"
    process = small.start(folder, devices=1)
    assert process.stdout is not None
    for line in process.stdout:
        if line.startswith("evaluation") and " 0 footsteps" not in line:
            break
    process.kill()
    process.communicate()
    with pair(folder, resume=True) as both:
        assert "resumed at" in ended(both[0])
        ended(both[1])
    alike(alone, folder)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ("--distributed --coordinator 127.0.0.1:1", "--processes and --process-id missing"),
        ("--distributed --processes 2", "--coordinator and --process-id missing"),
        ("--distributed --coordinator here --processes 2 --process-id 0", "give HOST:PORT"),
        ("--distributed --coordinator h:99999 --processes 2 --process-id 0", "port 1 to 65535"),
        ("--distributed --coordinator h:1 --processes 0 --process-id 0", "--processes 0"),
        ("--distributed --coordinator h:1 --processes 2 --process-id 2", "--process-id 2: give 0 to 1"),
        ("--coordinator h:1 --processes 2 --process-id 1", "give --distributed with them"),
    ],
)
def test_options_that_make_no_group_are_one_line(capsys, options, said):
    assert cli.main(["train", *options.split()]) == 2
    line = capsys.readouterr().err
    assert said in line and line.count("\n") == 1


def test_a_port_that_is_taken_is_one_line():
    with socket.create_server(("", 0)) as server:
        place = Place(f"127.0.0.1:{server.getsockname()[1]}", 2, 0)
        with pytest.raises(UserError, match="give a free port"), joined(place, "go on"):
            pass


def test_nobody_at_the_coordinator_is_one_line(tmp_path):
    """In a process of its own: nothing of JAX may have begun."""
    program = (
        "import sys; from jaxwalk import cli; from jaxwalk.common.parallel import launch;"
        "launch.CONNECT_SECONDS = 1;"
        f"sys.exit(cli.main('train --distributed --coordinator 127.0.0.1:{free_port()} --processes 2 "
        f"--process-id 1 --run-dir {tmp_path}/run'.split()))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == 2 and done.stderr.count("\n") == 1
    assert "no process 0 at --coordinator 127.0.0.1" in done.stderr and "start it" in done.stderr
    assert not (tmp_path / "run").exists()
