"""Where results go: a file is replaced whole, what is no file is written to and stays what it is."""

import os
import socket
import stat
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from jaxwalk.common import files
from jaxwalk.common.errors import UserError


def test_a_file_is_replaced_whole_and_nothing_lies_beside_it(tmp_path):
    path = tmp_path / "result.json"
    path.write_text("old")
    files.check_output("--json", path)
    assert path.read_text() == "old"
    files.write_json(path, {"a": 1})
    assert path.read_text() == '{\n  "a": 1\n}\n'
    assert os.listdir(tmp_path) == ["result.json"]


def test_a_pipe_is_written_to(tmp_path):
    path = tmp_path / "pipe"
    os.mkfifo(path)
    files.check_output("--json", path)
    read = []
    reader = threading.Thread(target=lambda: read.append(path.read_bytes()))
    reader.start()
    files.write_bytes(path, b"x" * 100_000)
    reader.join()
    assert read == [b"x" * 100_000]
    assert stat.S_ISFIFO(os.stat(path).st_mode)


def test_a_device_is_written_to():
    before = os.stat(os.devnull)
    files.check_output("--json", Path(os.devnull))
    files.write_bytes(Path(os.devnull), b"x")
    assert os.path.samestat(before, os.stat(os.devnull))
    with pytest.raises(UserError, match="/dev/full: No space left"):
        files.write_bytes(Path("/dev/full"), b"x")


def test_a_link_is_followed(tmp_path):
    (tmp_path / "elsewhere").mkdir()
    link = tmp_path / "link"
    link.symlink_to("elsewhere/result")
    for content in (b"first", b"second"):
        files.check_output("--json", link)
        files.write_bytes(link, content)
        assert link.is_symlink() and (tmp_path / "elsewhere/result").read_bytes() == content
    (tmp_path / "lost").symlink_to("nowhere/result")
    with pytest.raises(UserError, match="there is no folder"):
        files.check_output("--json", tmp_path / "lost")


def test_the_file_that_standard_output_goes_to_keeps_what_was_printed(tmp_path):
    program = "import pathlib; from jaxwalk.common import files; print('before');"
    program += "files.write_bytes(pathlib.Path('/dev/stdout'), b'result\\n'); print('after')"
    with (tmp_path / "log").open("a") as log:
        subprocess.run([sys.executable, "-c", program], stdout=log, check=True)
    assert (tmp_path / "log").read_text() == "before\nresult\nafter\n"


def test_a_socket_is_refused(tmp_path):
    path = tmp_path / "socket"
    with socket.socket(socket.AF_UNIX) as one:
        one.bind(os.fspath(path))
        with pytest.raises(UserError, match=r"--json .*socket"):
            files.check_output("--json", path)


def test_a_folder_that_takes_no_file_is_refused_at_once():
    """Though its rights say yes to whoever is root."""
    for check, path in ((files.check_output, "/proc/result.json"), (files.check_folder, "/proc/results")):
        with pytest.raises(UserError, match=r"--out /proc/result.* can be written"):
            check("--out", Path(path))


def test_a_folder_is_looked_at_without_a_trace(tmp_path):
    files.check_folder("--out", tmp_path / "new" / "results")
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize(
    ("held", "left"),
    [
        (b"", b""), (b"a\nb\n", b"a\nb\n"), (b"a\nb", b"a\n"), (b"stump", b""),
        (b"a\n" + b"x" * 200_000, b"a\n"), (b"x" * 2**16 + b"\n", b"x" * 2**16 + b"\n"),
    ],
)  # fmt: skip
def test_a_line_that_was_cut_short_is_dropped(tmp_path, held, left):
    log = tmp_path / "log"
    log.write_bytes(held)
    files.drop_stump(log)
    assert log.read_bytes() == left


def test_a_table_holds_no_formula_of_a_user_s():
    lines = [{"policy": name, "impulse": -40.0} for name in ("=1+1", "@x", "-a", "runs/=1")]
    assert files.to_csv(lines).decode().splitlines() == [
        "policy,impulse", "'=1+1,-40.0", "'@x,-40.0", "'-a,-40.0", "runs/=1,-40.0",
    ]  # fmt: skip
