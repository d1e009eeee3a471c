"""Reading an exported file: safetensors or npz, neither of which can execute anything."""

from __future__ import annotations

import json
import math
import os
import tokenize
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from jaxwalk.errors import UserError

FORMAT_VERSION = 1
MANIFEST = "jaxwalk_deploy"
"""Where a file keeps its manifest: a key of the safetensors header, an array of the npz."""
MAX_BYTES = 64 * 2**20
# What readers make of files that were altered.
_DAMAGED = (
    AttributeError, EOFError, KeyError, TypeError, RuntimeError, zipfile.BadZipFile, zlib.error,
    tokenize.TokenError,
)  # fmt: skip
_EXPECTED = "give a .safetensors or .npz file that jaxwalk export wrote"


def read(path: str | os.PathLike[str]) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """(manifest, tensors by name) of an exported file.

    Raises:
      UserError: no file, another kind of file, or a damaged one.
    """
    path = Path(path)
    readers = {".safetensors": _safetensors, ".npz": _npz}
    try:
        if path.suffix not in readers:
            raise ValueError("neither .safetensors nor .npz")
        if path.stat().st_size > MAX_BYTES:
            raise ValueError(f"more than {MAX_BYTES} bytes")
        text, tensors = readers[path.suffix](path)
        manifest = json.loads(text)
        version = manifest["format_version"]
    except OSError as error:
        raise UserError(f"policy {path}: cannot be read ({error.strerror or error}); {_EXPECTED}") from None
    except _DAMAGED:
        raise UserError(f"policy {path}: no whole export of a policy; {_EXPECTED}") from None
    except ValueError as error:
        said = "no whole export of a policy" if isinstance(error, UnicodeError) else str(error)
        raise UserError(f"policy {path}: {said}; {_EXPECTED}") from None
    if version != FORMAT_VERSION:
        raise UserError(
            f"policy {path}: format {version!r:.20}, but this jaxwalk reads {FORMAT_VERSION}; {_EXPECTED}"
        )
    return manifest, tensors


def _safetensors(path: Path) -> tuple[str, dict[str, np.ndarray]]:
    """The format is a length, a JSON header, and the numbers: no library is needed for float32."""
    content = path.read_bytes()
    size = int.from_bytes(content[:8], "little")
    if len(content) < 8 + size:
        raise ValueError("not a whole safetensors file")
    header = json.loads(content[8 : 8 + size])
    text = header.pop("__metadata__", {})[MANIFEST]
    data, tensors = content[8 + size :], {}
    for name, entry in header.items():
        begin, end = entry["data_offsets"]
        shape = entry["shape"]
        if entry["dtype"] != "F32" or end > len(data) or end - begin != 4 * math.prod(shape):
            raise ValueError(f"tensor {name!r:.40} is damaged or not float32")
        tensors[name] = np.frombuffer(data[begin:end], "<f4").astype(np.float32).reshape(shape)
    return text, tensors


def _npz(path: Path) -> tuple[str, dict[str, np.ndarray]]:
    with np.load(path, allow_pickle=False) as file:
        return str(file[MANIFEST]), {name: file[name] for name in file.files if name != MANIFEST}
