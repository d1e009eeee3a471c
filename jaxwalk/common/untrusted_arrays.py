"""Arrays from the bytes of safetensors and npz files, neither of which can execute anything.

What a header promises is compared with the bytes that are there before memory is taken for it. NumPy alone.
"""

from __future__ import annotations

import io
import math
import re
import zipfile
import zlib
from typing import Any

import numpy as np

from jaxwalk.common import untrusted
from jaxwalk.common.untrusted import Bad

_MAX_MEMBERS = 1000
# As NumPy writes it. Its own reader evaluates the text, and takes the memory before it sees the bytes.
_NPY_HEADER = re.compile(
    rb"\{'descr': '([<|][biufU][1-9]\d{0,7})', 'fortran_order': (True|False), "
    rb"'shape': \(((?:\d{1,18}, ?){0,7}\d{0,18})\), ?\}\s*"
)


def safetensors(content: bytes) -> tuple[dict[str, str], dict[str, np.ndarray]]:
    """(metadata, float32 arrays by name) of a safetensors file.

    The format is a length, a JSON header, and the numbers: no library is needed for float32.

    Raises:
      Bad: it is none, or holds numbers of another kind.
    """
    size = int.from_bytes(content[:8], "little")
    if len(content) < 8 or size > min(len(content) - 8, untrusted.MAX_JSON):
        raise Bad("not a whole safetensors file")
    header = untrusted.parse(content[8 : 8 + size])
    if not isinstance(header, dict):
        raise Bad("not a whole safetensors file")
    metadata = header.pop("__metadata__", {})
    if not isinstance(metadata, dict) or not all(isinstance(text, str) for text in metadata.values()):
        raise Bad("its metadata are damaged")
    data, tensors, spans = content[8 + size :], {}, []
    for name, entry in header.items():
        begin, end, shape = _entry(name, entry, len(data))
        spans.append((begin, end))
        tensors[name] = (begin, end, shape)
    # Each byte belongs to one tensor: or a small file could hold any number of large ones.
    ends = [0, *(end for _, end in sorted(spans)), len(data)]
    if [begin for begin, _ in sorted(spans)] + [len(data)] != ends[:-1]:
        raise Bad("its tensors overlap or leave gaps")
    return metadata, {
        name: np.frombuffer(data[begin:end], "<f4").astype(np.float32).reshape(shape)
        for name, (begin, end, shape) in tensors.items()
    }


def _entry(name: str, entry: Any, room: int) -> tuple[int, int, tuple[int, ...]]:
    """(first byte, byte after the last, shape) that a header tells of a tensor."""
    if not isinstance(entry, dict) or entry.keys() != {"dtype", "shape", "data_offsets"}:
        raise Bad(f"tensor {name!r:.40} is damaged")
    kind, shape, offsets = entry["dtype"], entry["shape"], entry["data_offsets"]
    if kind != "F32":
        raise Bad(f"tensor {name!r:.40} is {kind!r:.20}, not 'F32'")
    whole = all(
        isinstance(numbers, list) and all(type(x) is int and x >= 0 for x in numbers)
        for numbers in (shape, offsets)
    )
    if not whole or len(offsets) != 2 or len(shape) > 8:
        raise Bad(f"tensor {name!r:.40} is damaged")
    begin, end = offsets
    if not begin <= end <= room or end - begin != 4 * math.prod(shape):
        raise Bad(f"tensor {name!r:.40} is damaged")
    return begin, end, tuple(shape)


def npz(content: bytes, most: int) -> dict[str, np.ndarray]:
    """Arrays of numbers, truth values and text by name; read-only.

    Args:
      most: bytes that all of them may have together, unpacked.

    Raises:
      Bad: it is no npz file, or too large.
    """
    found = members(content, most)
    return {name.removesuffix(".npy"): _npy(name, part) for name, part in found.items()}


def members(content: bytes, most: int) -> dict[str, bytes]:
    """The files within a zip file, by name.

    Args:
      most: bytes that all of them may have together, unpacked.

    Raises:
      Bad: it is no zip file, or too large.
    """
    # Before the list of members is read: it can be many times as large in memory.
    if content.count(b"PK\x01\x02") > _MAX_MEMBERS:
        raise Bad(f"it holds more than {_MAX_MEMBERS} files")
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as file:
            told = file.infolist()
            if (size := sum(one.file_size for one in told)) > most:
                raise Bad(f"it unpacks to {size} bytes, more than the {most} that it may have")
            if len({one.filename for one in told}) < len(told):
                raise Bad("it holds two files of one name")
            return {one.filename: _unpacked(file, one) for one in told}
    # What Python makes of files that were altered.
    except (
        zipfile.BadZipFile, zlib.error, EOFError, RuntimeError, OSError, ValueError,
        OverflowError, KeyError, IndexError, AttributeError,
    ):  # fmt: skip
        raise Bad("not a whole zip file") from None


def _unpacked(file: zipfile.ZipFile, told: zipfile.ZipInfo) -> bytes:
    if told.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise zipfile.BadZipFile
    with file.open(told) as part:
        found = part.read(told.file_size)  # never more, whatever is packed there
    if len(found) != told.file_size:
        raise EOFError
    return found


def _npy(name: str, content: bytes) -> np.ndarray:
    """One array of an npz file."""
    wide = {b"\x93NUMPY\x01\x00": 2, b"\x93NUMPY\x02\x00": 4, b"\x93NUMPY\x03\x00": 4}.get(content[:8], 0)
    start = 8 + wide
    end = start + int.from_bytes(content[8:start], "little")
    header = _NPY_HEADER.fullmatch(content[start:end]) if wide else None
    if header is None:
        raise Bad(f"array {name!r:.40} is damaged or of another kind than numbers and text")
    descr, fortran, numbers = header.groups()
    shape = tuple(int(x) for x in numbers.replace(b",", b" ").split())
    try:
        kind = np.dtype(descr.decode())
        if math.prod(shape) * kind.itemsize != len(content) - end:
            raise Bad(f"array {name!r:.40} has not the size that it tells")
        order = "F" if fortran == b"True" else "C"
        found = np.frombuffer(content, kind, offset=end).reshape(shape, order=order)
        if kind.kind == "U":
            "".join(found.ravel().tolist()).encode()  # ValueError: what is no text
    except (TypeError, ValueError):
        raise Bad(f"array {name!r:.40} is damaged") from None
    if kind.kind == "b" and (found.view(np.uint8) > 1).any():
        raise Bad(f"array {name!r:.40} is damaged")
    return found
