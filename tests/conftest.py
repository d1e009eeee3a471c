"""For all tests: signatures are checked, compiled programs are remembered."""

import sys
from importlib import import_module
from pathlib import Path

import jaxtyping

sys.path.append(str(Path(__file__).parent))
# Before any module of the package is imported: every call's types and shapes are checked.
jaxtyping.install_import_hook("jaxwalk", "typecheck.check")

import_module("jaxwalk.common.runtime").setup()
