"""Files that are made to fill the memory, to keep a reader waiting, or to lead it elsewhere."""

from __future__ import annotations

import json
import os
import signal
import sys
import tracemalloc
import zipfile
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parent))

import mutations

from jaxwalk import deploy
from jaxwalk.common import untrusted, untrusted_arrays
from jaxwalk.common.errors import UserError
from jaxwalk.learn.policies import policy, provenance
from jaxwalk.learn.runs import run_folder
from jaxwalk.learn.train.checkpoint import Checkpoint, Store
from jaxwalk.learn.train.run_state import Past, Record
from jaxwalk.measure.push_map import table
from jaxwalk.measure.push_map.grid import Grid

SMALL = 2**20  # bytes that refusing a file may take, beside the file itself


def refused(read, path: Path, most: int = SMALL) -> str:
    """The line that says no, for which little memory was taken."""
    tracemalloc.start()
    try:
        with pytest.raises(UserError) as caught:
            read()
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    line = str(caught.value)
    assert str(path) in line and line.isprintable()
    # The file itself, as text, and a part of it.
    assert peak < most + (3 * path.stat().st_size if path.is_file() else 0), f"{peak} bytes for {line}"
    return line


def safetensors(header: object, data: bytes = b"") -> bytes:
    text = json.dumps(header).encode()
    return len(text).to_bytes(8, "little") + text + data


def entry(shape: list[int], begin: int = 0, end: int = 0, kind: str = "F32") -> dict[str, object]:
    return {"dtype": kind, "shape": shape, "data_offsets": [begin, end]}


def npy(descr: str, shape: str, data: bytes = b"") -> bytes:
    head = f"{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}".encode()
    return b"\x93NUMPY\x01\x00" + len(head).to_bytes(2, "little") + head + data


def zeros(size: int, told: int | None = None) -> bytes:
    """A zip file of so many zeros, which says that it has ``told``."""
    content = mutations.zipped({"a.npy": bytes(size)}, zipfile.ZIP_DEFLATED)
    return content.replace(size.to_bytes(4, "little"), (told or size).to_bytes(4, "little"))


def twins() -> bytes:
    return mutations.zipped({"a.npy": b"", "b.npy": b""}).replace(b"b.", b"a.")


HUGE = 2**40
# Made when they are wanted: some take a second.
BOMBS = {
    "shape": ("safetensors", lambda: safetensors({"x": entry([HUGE])}), "is damaged"),
    "shape and offsets": (
        "safetensors",
        lambda: safetensors({"x": entry([HUGE], 0, 4 * HUGE)}),
        "is damaged",
    ),
    "negative shape": (
        "safetensors",
        lambda: safetensors({"x": entry([-1, -1], 0, 4)}, bytes(4)),
        "is damaged",
    ),
    "header": ("safetensors", lambda: (2**63).to_bytes(8, "little") + b"{}", "not a whole safetensors file"),
    "overlap": (
        "safetensors",
        lambda: safetensors({f"x{i}": entry([250_000], 0, 1_000_000) for i in range(1000)}, bytes(1_000_000)),
        "overlap",
    ),
    "gap": ("safetensors", lambda: safetensors({"x": entry([1], 4, 8)}, bytes(8)), "leave gaps"),
    "npy shape": ("npz", lambda: mutations.zipped({"a.npy": npy("<f4", f"({HUGE},)")}), "has not the size"),
    "npy text": (
        "npz",
        lambda: mutations.zipped({"a.npy": npy("<U9999999", "(9999999,)")}),
        "has not the size",
    ),
    "npy header": ("npz", lambda: mutations.zipped({"a.npy": npy("<f4", "(" * 5000)}), "is damaged"),
    "npy pickle": ("npz", lambda: mutations.zipped({"a.npy": mutations.npy([object()])}), "of another kind"),
    "zip of zeros": ("npz", lambda: zeros(100 * 2**20), "it unpacks to"),
    "zip that lies": ("npz", lambda: zeros(100 * 2**20, told=4), "not a whole zip file"),
    "zip of many": (
        "npz",
        lambda: mutations.zipped({f"{i}": b"" for i in range(2000)}),
        "more than 1000 files",
    ),
    "zip of twins": ("npz", twins, "of one name"),
    "nothing": ("npz", lambda: b"", "not a whole zip file"),
}


@pytest.mark.parametrize("case", BOMBS)
def test_what_is_promised_is_not_what_is_taken(tmp_path, case):
    kind, content, says = BOMBS[case]
    path = tmp_path / f"policy.{kind}"
    path.write_bytes(content())
    assert says in refused(lambda: deploy.load(path), path)
    if kind == "safetensors":
        assert says in refused(lambda: policy.load(path), path)


DEEP = {
    "lists": "[" * 10_000_000,
    "objects": '{"a":' * 1_000_000,
    "a list": "[" * 100 + "]" * 100,
    "digits": "9" * 10_000_000,
    "a number": "1e999",
    "minus": "-" * 1_000_000,
}


@pytest.mark.parametrize("case", DEEP)
def test_json_without_end(tmp_path, case):
    path = tmp_path / "config.json"
    path.write_text(DEEP[case])
    refused(lambda: run_folder.load_record(path), path, 2**22)
    refused(lambda: provenance.read(path, "evaluate"), path, 2**22)


def test_a_name_that_is_there_twice_among_many_is_found():
    """By looking at each once: pair by pair it would take minutes."""
    with pytest.raises(untrusted.Bad, match="'199999' is there twice"):
        untrusted.parse("{" + "".join(f'"{i}":0,' for i in range(200_000)) + '"199999":0}')


def test_json_is_utf8_and_says_nothing_twice():
    for text, says in (
        (b"\xff\xfe[\x00]\x00", "not UTF-8"), (b"\xef\xbb\xbf{}", "not JSON"), (b'{"a": 1, "a": 2}', "twice"),
        (b"[NaN]", "no number"), (b"[1e999]", "out of range"), (b"[18446744073709551616]", "out of range"),
        (b"", "not JSON"), (b"[1,]", "not JSON"),
    ):  # fmt: skip
        with pytest.raises(untrusted.Bad, match=says):
            untrusted.parse(text)
    assert untrusted.parse('{"a": [1, -2.5e3, "\\u00e9", null, true]}') == {
        "a": [1, -2500.0, "é", None, True]
    }


GRID = Grid((1.0,), (0.0,), ("torso",), (0.1,), 1, 0)
READERS = {
    "policy": ("p.safetensors", policy.load, policy.MAX_BYTES),
    "export": ("p.npz", deploy.load, policy.MAX_BYTES),
    "run": ("config.json", run_folder.load_config, untrusted.MAX_JSON),
    "metrics": ("metrics.jsonl", lambda path: run_folder.read_metrics(path.parent), run_folder.MAX_METRICS),
    "result": ("e.json", lambda path: provenance.read(path, "evaluate"), untrusted.MAX_JSON),
    "map": (table.NAME, lambda path: table.resume(path.parent, GRID, {}), 2**21),
}  # fmt: skip


@pytest.mark.parametrize("name", READERS)
def test_only_ordinary_files_of_ordinary_size(tmp_path, name):
    file, read, most = READERS[name]
    path = tmp_path / file

    def stuck(*_: object) -> None:
        raise AssertionError("the reader waits for ever")

    def no(*says: str) -> None:
        before = signal.signal(signal.SIGALRM, stuck)
        signal.alarm(60)
        try:
            line = refused(lambda: read(path), path)
        finally:
            signal.alarm(0)
            signal.signal(signal.SIGALRM, before)
            path.unlink()
        assert any(one in line for one in says), line

    os.mkfifo(path)
    no("not an ordinary file")
    path.symlink_to("/dev/zero")
    no("not an ordinary file")
    path.symlink_to(path.name)
    no("symbolic links")
    path.symlink_to(tmp_path)
    no("Is a directory", "no configuration", f"{tmp_path}/config.json")
    path.touch()
    os.truncate(path, most + 1)
    no(f"{most + 1} bytes, more than")


def test_a_checkpoint_larger_than_the_run_is_not_unpacked(tmp_path):
    store = Store(tmp_path / "resume", "mine")
    store.save(Checkpoint({"x": np.zeros((4096, 4096), np.float32)}, {}), wait=True)  # packed, almost nothing
    store.close()
    store = Store(tmp_path / "resume", "mine")
    line = refused(lambda: store.latest(print, 2**20), tmp_path / "resume", 2**24)
    assert "its arrays are larger than those of this run" in line
    (tmp_path / "resume" / "0" / "link").symlink_to("/dev/zero")
    assert "something else than files" in refused(
        lambda: store.latest(print, 2**30), tmp_path / "resume", 2**24
    )
    store.close()


def test_notes_of_a_checkpoint_are_those_of_a_run_or_refused():
    past = Past(3, Record(seconds=1.5, found={}, divergences=[{"footsteps": 1, "back_to": 0}]), [(7, 0.5)])
    notes = json.loads(json.dumps(past.to_notes()))
    assert Past.from_notes(notes) == past
    bad = 0
    for where in (("rows",), ("finalists",), *(("record", name) for name in notes["record"])):
        for value in mutations.HOSTILE:
            *way, last = where
            changed = json.loads(json.dumps(notes))
            (changed[way[0]] if way else changed)[last] = value
            try:
                Past.from_notes(changed)
            except (KeyError, TypeError, ValueError, AttributeError):
                bad += 1
    assert bad > 100


def test_arrays_of_files_come_back_as_they_were():
    kept = {
        "a": np.arange(6, dtype=np.float32).reshape(2, 3), "b": np.asfortranarray(np.ones((3, 2), np.int32)),
        "text": np.array("é, and\nmore"), "names": np.array(["x", "torso"]), "none": np.zeros((0, 3), bool),
        "one": np.float32(3.5),
    }  # fmt: skip
    packed = mutations.zipped({f"{name}.npy": mutations.npy(x) for name, x in kept.items()})
    for name, x in untrusted_arrays.npz(packed, 2**20).items():
        np.testing.assert_array_equal(x, kept[name], strict=True)
