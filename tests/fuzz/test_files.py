"""Any file ends in success or in one clear line that names it, whatever was done to it: see files.py."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest


# 1,500 changed files and 150 results in some seconds; half a million in minutes.
@pytest.mark.parametrize("count", [150, pytest.param(40_000, marks=pytest.mark.slow)])
def test_changed_files_end_in_success_or_in_one_line(count):
    program = [sys.executable, str(Path(__file__).with_name("files.py")), str(count)]
    done = subprocess.run(program, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.splitlines()[-1] == "results of bench"  # the last kind of file
