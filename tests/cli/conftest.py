"""Commands run in this process, with recorders in place of the programs behind them."""

import importlib
import sys
import types

import pytest

from jaxwalk.cli import main


@pytest.fixture
def called(monkeypatch):
    """What the commands hand on: a list of argument tuples."""
    calls = []
    modules = {
        "learn.train.run": ("run", "resume"),
        "measure.evaluate.command": ("main",),
        "show.render.command": ("main",),
        "measure.bench.command": ("main",),
    }
    for module, functions in modules.items():
        recorder = types.SimpleNamespace(**{name: lambda *args: calls.append(args) for name in functions})
        path = f"jaxwalk.{module}"
        monkeypatch.setitem(sys.modules, path, recorder)
        # Once imported, a module is found as its package's attribute.
        package, _, name = path.rpartition(".")
        monkeypatch.setattr(importlib.import_module(package), name, recorder, raising=False)
    return calls


@pytest.fixture
def jaxwalk_cli(called, capsys):
    """Runs a command line; gives (exit code, standard output, standard error)."""

    def run(*argv):
        code = main([str(arg) for arg in argv])
        return code, *capsys.readouterr()

    return run
