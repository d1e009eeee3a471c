"""Commands run in this process, with recorders in place of the programs behind them."""

import sys
import types

import pytest

import jaxwalk
from jaxwalk.cli import main


@pytest.fixture
def called(monkeypatch):
    """What the commands hand on: a list of argument tuples."""
    calls = []
    for module, function in (("train", "run"), ("evaluate", "main"), ("render", "main"), ("bench", "main")):
        recorder = types.SimpleNamespace(**{function: lambda *args: calls.append(args)})
        monkeypatch.setitem(sys.modules, f"jaxwalk.{module}", recorder)
        monkeypatch.setattr(jaxwalk, module, recorder, raising=False)
    return calls


@pytest.fixture
def jaxwalk_cli(called, capsys):
    """Runs a command line; gives (exit code, standard output, standard error)."""

    def run(*argv):
        code = main([str(arg) for arg in argv])
        return code, *capsys.readouterr()

    return run
