"""Commands in hostile circumstances: the usual result, or one line and nothing left behind."""

import os
import signal
import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parent))

from circumstances import CIRCUMSTANCES, Circumstance, ended, started

QUICK = ["export", "shipped", "--format", "npz", "--out", "out"]
_SMALL = ["--impulses", "30", "--phases", "1", "--replicas", "1"]
SLOW = {
    "evaluate": ["evaluate", "shipped", "--seconds", "5", "--walkers", "2", *_SMALL, "--json", "out.json"],
    "push-map": ["push-map", "shipped", *_SMALL, "--out", "out"],
    "render": ["render", "shipped", "--impulses", "30", "--out", "out.html"],
    "train": ["train", "--preset", "smoke", "--run-dir", "out"],
}
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL)


def look(argv, folder, one):
    """See that a command does what it should."""
    code, error = ended(started(argv, folder, one))
    assert code == one.code, error
    assert "Traceback" not in error
    left = sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())
    if code:
        assert error.startswith("jaxwalk: error: ") and error.count("\n") == 1, error
        assert left == []
    else:
        assert left and not [name for name in left if "/.jaxwalk." in f"/{name}"], left


@pytest.mark.parametrize("name", CIRCUMSTANCES)
def test_a_command_in_each_circumstance(tmp_path, name):
    look(QUICK, tmp_path, CIRCUMSTANCES[name])


@pytest.mark.slow
@pytest.mark.parametrize("name", CIRCUMSTANCES)
@pytest.mark.parametrize("command", SLOW)
def test_each_command_in_each_circumstance(tmp_path, command, name):
    look(SLOW[command], tmp_path, CIRCUMSTANCES[name])


@pytest.mark.slow
@pytest.mark.parametrize("number", SIGNALS)
@pytest.mark.parametrize("command", SLOW)
@pytest.mark.parametrize("reads", [0, 1])
def test_a_signal_leaves_no_half_of_a_file(tmp_path, command, number, reads):
    """At once, and when the command has first said what it does."""
    process = started(SLOW[command], tmp_path, Circumstance())
    for _ in range(reads):
        assert process.stdout is not None and process.stdout.readline()
    os.kill(process.pid, number)
    code, error = ended(process)
    assert code in (-number, 128 + number)
    assert "Traceback" not in error
    assert not list(tmp_path.rglob(".jaxwalk.*"))
