"""For all tests: signatures are checked, compiled programs are remembered."""

import gc
import sys
from importlib import import_module
from pathlib import Path

sys.path.append(str(Path(__file__).parent))
# Before any module of the package is imported: every call's types and shapes are checked.
import_module("typecheck").install()

import_module("jaxwalk.common.runtime").setup()


def pytest_collection_finish():
    """What is imported by then stays: to go over all of it at each collection costs minutes."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(100_000, 20, 50)
