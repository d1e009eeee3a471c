"""For all tests: signatures are checked, compiled programs are remembered."""

import sys
from importlib import import_module
from pathlib import Path

sys.path.append(str(Path(__file__).parent))
# Before any module of the package is imported: every call's types and shapes are checked.
import_module("typecheck").install()

import_module("jaxwalk.common.runtime").setup()
