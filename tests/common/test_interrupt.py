"""Signals end a training well, and its process with the code that says which."""

import os
import signal
import subprocess
import sys
import types

import pytest

from jaxwalk import cli
from jaxwalk.common.interrupt import Stop


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)]
)
def test_a_training_that_a_signal_ended_says_so_by_its_exit_code(monkeypatch, capfd, number, code):
    def train(args):
        with Stop() as stop:
            assert not stop.wanted
            os.kill(os.getpid(), number)
            assert stop.wanted
        print("kept")

    monkeypatch.setitem(sys.modules, "jaxwalk.measure.bench.command", types.SimpleNamespace(main=train))
    before = signal.getsignal(number)
    assert cli.main(["bench"]) == code
    assert signal.getsignal(number) is before
    out, error = capfd.readouterr()
    assert out == "kept\n" and error.startswith("stopping after the report under way")
    monkeypatch.setitem(
        sys.modules, "jaxwalk.measure.bench.command", types.SimpleNamespace(main=lambda args: None)
    )
    assert cli.main(["bench"]) == 0


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_ctrl_c_that_was_lost_is_told_by_the_exit_code(monkeypatch, capsys):
    class Lost:
        def __del__(self):
            os.kill(os.getpid(), signal.SIGINT)

    def measure(args):
        Lost()
        print("measured")

    monkeypatch.setitem(sys.modules, "jaxwalk.measure.bench.command", types.SimpleNamespace(main=measure))
    assert cli.main(["bench"]) == 130
    assert capsys.readouterr().out == "measured\n"


def test_what_the_process_was_started_to_ignore_stays_ignored(monkeypatch):
    """As nohup has it."""
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with Stop() as stop:
            os.kill(os.getpid(), signal.SIGHUP)
            assert not stop.wanted
    finally:
        signal.signal(signal.SIGHUP, before)


def test_ctrl_c_before_the_work_begins_says_nothing():
    """While the package is imported: an import that is broken off would print a traceback."""
    program = "import os, signal, sys; sys.argv = ['jaxwalk', '--help'];"
    program += "sys.meta_path.insert(0, type('Finder', (), {'find_spec': staticmethod(lambda name, *_: "
    program += "os.kill(os.getpid(), signal.SIGINT) if name == 'jaxwalk.cli' else None)}));"
    program += "from jaxwalk.__main__ import main; main()"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (-signal.SIGINT, b"", b"")
