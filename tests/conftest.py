"""For all tests: signatures are checked, compiled programs are remembered."""

import gc
import os
import sys
from importlib import import_module
from pathlib import Path

# XLA's dearer passes take half of the tests' time and change nothing that they say; JAX's own CI does so too.
# Before JAX is imported; the processes that tests start inherit it.
os.environ.setdefault("JAX_DISABLE_MOST_OPTIMIZATIONS", "1")

sys.path.append(str(Path(__file__).parent))
# Before any module of the package is imported: every call's types and shapes are checked.
import_module("typecheck").install()

import_module("jaxwalk.common.runtime").setup()


def pytest_collection_finish():
    """What is imported by then stays: to go over all of it at each collection costs minutes."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(100_000, 20, 50)
