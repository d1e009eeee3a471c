"""The processes of a walk through ROS: begun, watched, and all ended, whatever happens."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

from jaxwalk.common.errors import UserError

PACKAGES = (
    "libode8 ros-core python3-numpy python3-rospy python3-rosmaster python3-roslaunch python3-rosbag "
    "python3-sensor-msgs python3-geometry-msgs python3-std-msgs python3-std-srvs python3-rosgraph-msgs"
)
"""Debian's, that all of it needs."""
_NEEDED = (
    "import ctypes, numpy, rospy, rosmaster, rosgraph, genpy, sensor_msgs.msg, geometry_msgs.msg;"
    "import std_msgs.msg, std_srvs.srv, rosgraph_msgs.msg; ctypes.CDLL('libode.so.8')"
)
PATIENCE = 10.0  # s that a process may take to end when it is asked to


def check(python: Path) -> None:
    """That ``python`` has what the nodes need.

    Raises:
      UserError: it does not, or is not there.
    """
    try:
        done = subprocess.run(
            [str(python), "-c", _NEEDED], capture_output=True, text=True, timeout=60, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        raise UserError(f"--python {python}: does not run: give the Python of Debian's ROS") from None
    if done.returncode:
        why = (done.stderr.strip().splitlines() or ["?"])[-1]
        raise UserError(f"{python} lacks what ROS needs ({why}): apt-get install {PACKAGES}")


def free_port() -> int:
    """A port of 127.0.0.1 that nobody listens at."""
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


@contextlib.contextmanager
def surroundings(out: Path, master: str) -> Iterator[dict[str, str]]:
    """The variables that processes are given: ROS on this machine, and of this environment the package alone.

    Its other packages are another Python's: the nodes have Debian's.
    """
    with tempfile.TemporaryDirectory(prefix="jaxwalk-ros.") as folder:
        os.symlink(Path(__file__).resolve().parent.parent, Path(folder) / "jaxwalk", target_is_directory=True)
        own = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
        path = {"PYTHONPATH": folder, "PYTHONDONTWRITEBYTECODE": "1"}
        ros = {"ROS_MASTER_URI": master, "ROS_IP": "127.0.0.1", "ROS_HOME": str(out / "ros")}
        own.pop("ROS_HOSTNAME", None)
        yield own | path | ros


class Processes:
    """What was begun, to be ended in the end, the last first.

    Args:
      variables: of the environment. folder: for a log of each.

    Attributes:
      variables: as above, of what is begun from now on.
    """

    def __init__(self, variables: dict[str, str], folder: Path) -> None:
        self.variables, self._folder = variables, folder
        self._running: list[subprocess.Popen[bytes]] = []

    def __enter__(self) -> Processes:
        # Who is told to end (SIGTERM) ends what he began, as at Ctrl-C.
        self._before = signal.signal(signal.SIGTERM, signal.default_int_handler)
        return self

    def begin(self, name: str, *line: str) -> subprocess.Popen[bytes]:
        """Start ``line``; what it says goes to NAME.log.

        Raises:
          UserError: there is no such program.
        """
        with open(self._folder / f"{name}.log", "wb") as log:
            try:
                one = subprocess.Popen(
                    line,
                    stdout=log,
                    stderr=subprocess.STDOUT,
                    stdin=subprocess.DEVNULL,
                    env=self.variables,
                    cwd=self._folder,
                    start_new_session=True,  # Ctrl-C is for whoever ends them
                )
            except OSError:
                raise UserError(f"{line[0]} does not run: apt-get install {PACKAGES}") from None
        self._running.append(one)
        return one

    def said(self, name: str) -> str:
        """The last line of NAME.log."""
        lines = (self._folder / f"{name}.log").read_text(encoding="utf-8", errors="replace").strip()
        return (lines.splitlines() or ["nothing"])[-1]

    def end(self, one: subprocess.Popen[bytes]) -> None:
        """End ``one`` and what it started, by force where it takes too long."""
        for how in (signal.SIGINT, signal.SIGKILL):
            if one.poll() is None:
                with contextlib.suppress(ProcessLookupError):
                    os.killpg(one.pid, how)
                with contextlib.suppress(subprocess.TimeoutExpired):
                    one.wait(PATIENCE)

    def __exit__(self, *_: object) -> None:
        while self._running:
            self.end(self._running.pop())
        signal.signal(signal.SIGTERM, self._before)
