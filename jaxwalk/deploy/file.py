"""Reading an exported file: safetensors or npz, neither of which can execute anything."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from jaxwalk.common import untrusted, untrusted_arrays
from jaxwalk.common.errors import UserError

FORMAT_VERSION = 2
READS = (1, 2)
"""Formats that are read: in the first, steps are never decided anew and legs are rigid."""
MANIFEST = "jaxwalk_deploy"
"""Where a file keeps its manifest: a key of the safetensors header, an array of the npz."""
MAX_BYTES = 64 * 2**20  # a default policy has half a megabyte
_CURE = "give a .safetensors or .npz file that jaxwalk export wrote"


def read(path: str | os.PathLike[str]) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """(manifest, tensors by name) of an exported file.

    Raises:
      UserError: no file, another kind of file, or a damaged one.
    """
    path = Path(path)
    readers = {".safetensors": _safetensors, ".npz": _npz}
    if path.suffix not in readers:
        raise UserError(untrusted.unreadable(path, "neither .safetensors nor .npz", _CURE))
    content = untrusted.content(path, MAX_BYTES, _CURE)
    try:
        text, tensors = readers[path.suffix](content)
        if text is None:
            raise untrusted.Bad("not of an exported policy")
        manifest = untrusted.parse(text)
        if not isinstance(manifest, dict):
            raise untrusted.Bad("its manifest is damaged")
    except untrusted.Bad as bad:
        raise UserError(untrusted.unreadable(path, bad, _CURE)) from None
    version = manifest.get("format_version")
    if version not in READS:
        raise UserError(
            f"policy {path}: format {version!r:.20}, but this jaxwalk reads "
            f"{READS[0]} to {READS[-1]}; {_CURE}"
        )
    return manifest, tensors


def _safetensors(content: bytes) -> tuple[str | None, dict[str, np.ndarray]]:
    metadata, tensors = untrusted_arrays.safetensors(content)
    return metadata.get(MANIFEST), tensors


def _npz(content: bytes) -> tuple[str | None, dict[str, np.ndarray]]:
    found = untrusted_arrays.npz(content, MAX_BYTES)
    text = found.pop(MANIFEST, None)
    return None if text is None or text.ndim or text.dtype.kind != "U" else str(text), found
