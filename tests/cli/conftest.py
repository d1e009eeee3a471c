"""Commands run in this process, with recorders in place of the programs behind them."""

import importlib
import sys
import types
from pathlib import Path

import pytest

from jaxwalk import cli
from jaxwalk.cli import main


@pytest.fixture
def called(monkeypatch):
    """What the commands hand on: a list of argument tuples."""
    calls = []

    def recorded(*args):
        calls.append(args)
        return Path("run")

    modules = {
        "learn.train.run": ("run", "resume"),
        "measure.evaluate.command": ("main",),
        "show.render.command": ("main",),
        "measure.bench.command": ("main",),
    }
    for module, functions in modules.items():
        recorder = types.SimpleNamespace(**dict.fromkeys(functions, recorded))
        path = f"jaxwalk.{module}"
        monkeypatch.setitem(sys.modules, path, recorder)
        # Once imported, a module is found as its package's attribute.
        package, _, name = path.rpartition(".")
        monkeypatch.setattr(importlib.import_module(package), name, recorder, raising=False)
    # What they say at their end would need what they make.
    monkeypatch.setattr(cli, "_NEXT", {})
    monkeypatch.setattr("jaxwalk.learn.train.beside.lines", lambda folder: [])
    return calls


@pytest.fixture
def jaxwalk_cli(called, capsys):
    """Runs a command line; gives (exit code, standard output, standard error)."""

    def run(*argv):
        code = main([str(arg) for arg in argv])
        return code, *capsys.readouterr()

    return run
