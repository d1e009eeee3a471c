"""Output that nobody reads any more, as of ``jaxwalk train --help | head -1``: a quiet end."""

import os
import subprocess
import sys
from typing import Any

import pytest

ITSELF = "import sys; from jaxwalk.cli import main; sys.exit(main(sys.argv[1:]))"
# A command that prints as most do, without the minutes that they take.
RICH = """
import sys, types
from rich.console import Console
from jaxwalk.cli import main
canned = types.SimpleNamespace(main=lambda args: Console().print("measured"))
sys.modules["jaxwalk.measure.bench.command"] = canned
sys.exit(main(["bench"]))
"""


@pytest.mark.parametrize(
    ("program", "argv", "closed"),
    [
        (ITSELF, ["--help"], "stdout"),
        (ITSELF, ["--version"], "stdout"),
        (ITSELF, ["train", "--help"], "stdout"),
        (RICH, [], "stdout"),
        (ITSELF, ["trian"], "stderr"),
    ],
)
def test_a_closed_pipe_is_no_error_of_ours(program, argv, closed):
    reader, writer = os.pipe()
    os.close(reader)
    streams: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, closed: writer}
    done = subprocess.run([sys.executable, "-c", program, *argv], **streams, check=False)
    os.close(writer)
    assert (done.returncode, done.stdout or b"", done.stderr or b"") == (141, b"", b"")
