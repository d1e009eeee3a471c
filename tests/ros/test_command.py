"""What counts as a master, and what the ROS package's program says."""

from __future__ import annotations

import contextlib
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from jaxwalk.ros import command, processes


@pytest.mark.parametrize("said", [b"", b"garbage\n", b"<a>", b"<methodResponse></methodResponse>"])
def test_what_is_no_master_does_not_answer(monkeypatch, said):
    monkeypatch.setattr(command, "_ANSWERING", 0.3)
    raw = said == b"garbage\n"
    head = b"HTTP/1.0 200 OK\r\nContent-Type: text/xml\r\nContent-Length: %d\r\n\r\n" % len(said)
    done = threading.Event()
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve():
            # xmlrpc asks a second time where it was hung up on.
            with contextlib.suppress(OSError):
                while True:
                    one, _ = server.accept()
                    with one:
                        one.recv(4096)
                        if not said:
                            done.wait(60.0)  # takes the call and is silent
                        one.sendall(said if raw else head + said)

        threading.Thread(target=serve, daemon=True).start()
        begun = time.monotonic()
        assert not command.answers(f"http://127.0.0.1:{server.getsockname()[1]}")
        assert time.monotonic() - begun < 30.0
        done.set()
        server.shutdown(socket.SHUT_RDWR)


@pytest.mark.parametrize(
    "address", ["nonsense", "ftp://a", "http://127.0.0.1:port", "http://[", "http://127.0.0.1:1"]
)
def test_what_is_no_address_does_not_answer(address):
    assert not command.answers(address)


@pytest.mark.parametrize("told", [[], ["nobody_node"], ["../node"], ["two\nlines"]])
def test_the_packages_program_names_the_nodes(told):
    program = Path(command.__file__).parent / "package" / "node"
    done = subprocess.run([sys.executable, program, *told], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.endswith("give one of controller_node, push_node, simulation_node\n")
    assert len(done.stderr.splitlines()) == 1


def test_all_lists_of_packages_are_one():
    """CI once asked for a package that Debian has not, and tested nothing."""
    root = Path(__file__).parents[2]
    run, page = (root / ".ci" / "run").read_text(), (root / "docs" / "ros.md").read_text()
    in_ci = run[run.index('ros="') + 5 :].split('"')[0].split()
    at = page.index("apt-get install ros-core") + len("apt-get install ")
    on_page = page[at:].split("\n\n")[0].replace("\\\n", " ").split()
    wanted = set(processes.PACKAGES.split())
    assert {"libode8", *in_ci} == {"libode8", *on_page} == wanted
