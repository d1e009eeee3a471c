"""What chance and malice make of valid files: changes of bytes, of JSON values, of what archives hold."""

from __future__ import annotations

import copy
import io
import json
import math
import zipfile
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from hypothesis import strategies as st

_DEEP: Any = []
for _ in range(100):
    _DEEP = [_DEEP]
HOSTILE = (
    None, True, False, 0, -1, 1, 2**31, 2**63, -(10**30), 0.5, -0.5, 1e308, -1e308, 5e-324, math.nan,
    math.inf, "", "x", "winter", "\x1b[2J\nsecond line",
    "\ud800", "../../etc", "9" * 1000, [], {}, [[]], [0.0] * 9,
    [None, "a"], {"a": 1}, _DEEP,
)  # fmt: skip


def _places(value: Any, where: tuple = ()) -> Iterator[tuple]:
    """The path of every value within ``value``."""
    yield where
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for name, one in inner:
        yield from _places(one, (*where, name))


def json_values(value: Any) -> st.SearchStrategy[Any]:
    """``value`` with one to three of the values in it exchanged, taken out, renamed or repeated."""
    places = list(_places(value))

    @st.composite
    def changed(draw: st.DrawFn) -> Any:
        holder = {"all": copy.deepcopy(value)}
        for _ in range(draw(st.integers(1, 3))):
            *way, last = ("all", *draw(st.sampled_from(places)))
            within: Any = holder
            try:
                for name in way:
                    within = within[name]
                within[last]
            except (KeyError, IndexError, TypeError):
                continue  # an earlier change took it away
            if not isinstance(within, dict | list):
                continue
            what = draw(st.sampled_from(("exchange", "exchange", "take out", "rename", "repeat")))
            if what == "exchange" or within is holder:
                within[last] = copy.deepcopy(draw(st.sampled_from(HOSTILE)))
            elif what == "take out":
                del within[last]
            elif isinstance(within, list):
                within.append(within[last])
            else:
                within["x" if what == "rename" else f"{last}2"] = within.pop(last)
        return holder["all"]

    return changed()


def texts(value: Any) -> st.SearchStrategy[str]:
    """JSON of `json_values`, and now and then with a name twice."""
    changed = json_values(value).map(json.dumps)
    twice = changed.map(lambda text: text.replace("{", '{"x": 1, "x": 2, ', 1))
    return st.one_of(changed, changed, changed, twice)


def contents(content: bytes, other: bytes = b"") -> st.SearchStrategy[bytes]:
    """``content`` with one to three changes of its bytes; ``other`` is spliced in.

    Mostly in the first bytes and the last: there formats keep their structure.
    """

    @st.composite
    def changed(draw: st.DrawFn) -> bytes:
        found = content
        for _ in range(draw(st.integers(1, 3))):
            size = len(found)
            place = draw(
                st.one_of(
                    st.integers(0, min(size, 2000)),
                    st.integers(max(0, size - 1500), size),
                    st.integers(0, size),
                )
            )
            span = draw(st.sampled_from((1, 1, 1, 2, 8, 100, 5000)))
            before, middle, after = found[:place], found[place : place + span], found[place + span :]
            some = st.one_of(st.binary(min_size=1, max_size=8), st.sampled_from((b"\0" * 8, b"\xff" * 8)))
            what = draw(st.sampled_from(("put", "put", "insert", "delete", "repeat", "cut", "splice")))
            fresh = draw(some)
            found = {
                "put": before + fresh + after,
                "insert": before + fresh + middle + after,
                "delete": before + after,
                "repeat": before + middle * 2 + after,
                "cut": before,
                "splice": before + other[place:],
            }[what]
        return found

    return changed()


def json_files(value: Any) -> st.SearchStrategy[bytes]:
    whole = json.dumps(value, indent=1).encode()
    return st.one_of(texts(value).map(str.encode), texts(value).map(str.encode), contents(whole, whole))


def safetensors_files(content: bytes, inner: Mapping[str, tuple[str, ...]]) -> st.SearchStrategy[bytes]:
    """Changes of a safetensors file, of its header, and of the JSON texts in its metadata.

    Args:
      inner: names of metadata that are JSON texts, and which of their values are such texts again.
    """
    size = int.from_bytes(content[:8], "little")
    header, data = json.loads(content[8 : 8 + size]), content[8 + size :]

    def packed(text: str) -> bytes:
        return len(text.encode()).to_bytes(8, "little") + text.encode() + data

    def with_text(name: str, text: str) -> bytes:
        told = header["__metadata__"] | {name: text}
        return packed(json.dumps(header | {"__metadata__": told}))

    kinds = [contents(content, data), texts(header).map(packed), texts(header).map(packed)]
    for name, texts_within in inner.items():
        value = json.loads(header["__metadata__"][name])
        kinds += [texts(value).map(lambda text, n=name: with_text(n, text))] * 2
        for one in texts_within:
            kinds.append(
                texts(json.loads(value[one])).map(
                    lambda text, n=name, v=value, o=one: with_text(n, json.dumps(v | {o: text}))
                )
            )
    return st.one_of(kinds)


def zipped(parts: Mapping[str, bytes], how: int = zipfile.ZIP_STORED) -> bytes:
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", how) as file:
        for name, part in parts.items():
            file.writestr(zipfile.ZipInfo(name), part, how)
    return content.getvalue()


def npy(array: Any) -> bytes:
    content = io.BytesIO()
    np.save(content, array, allow_pickle=True)  # as an attacker would
    return content.getvalue()


_EXCHANGED = (
    (b"'<f4'", b"'<f8'"), (b"'<f4'", b"'|O8'"), (b"'<f4'", b"'>f4'"), (b"'<f4'", b"'<i4'"), (b"<f4", b"<U9"),
    (b"(", b"(9999999999, "), (b"(", b"(0, "), (b"(", b"(-1, "), (b"(", b"(" * 50), (b"'", b'"'),
    (b"False", b"True"), (b"False", b"__import__('os').abort()"), (b"|b1", b"|i1"), (b"(", b"(1, " * 40),
)  # fmt: skip

_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2)


def npz_files(content: bytes, text: str) -> st.SearchStrategy[bytes]:
    """Changes of an npz file, of the arrays in it, and of the JSON text that its array ``text`` is."""
    with zipfile.ZipFile(io.BytesIO(content)) as file:
        parts = {name: file.read(name) for name in file.namelist()}
    told = json.loads(str(np.load(io.BytesIO(parts[f"{text}.npy"]))))
    names = st.sampled_from(sorted(parts))

    @st.composite
    def rearranged(draw: st.DrawFn) -> bytes:
        name, found = draw(names), dict(parts)
        what = draw(st.sampled_from(("header", "header", "bytes", "take out", "rename", "exchange")))
        if what == "header":
            old, new = draw(st.sampled_from(_EXCHANGED))
            found[name] = found[name].replace(old, new, 1)
        elif what == "bytes":
            found[name] = draw(contents(found[name]))
        elif what == "take out":
            del found[name]
        elif what == "rename":
            found["x.npy"] = found.pop(name)
        else:
            hostile = (None, {}, 1.5, "x", b"x", np.zeros(3), np.zeros((2, 2), np.float32), [object()])
            found[name] = npy(np.array(draw(st.sampled_from(hostile))) if draw(st.booleans()) else np.nan)
        return zipped(found, draw(st.sampled_from(_METHODS)))

    def with_text(changed: str) -> bytes:
        return zipped(parts | {f"{text}.npy": npy(np.array(changed))})

    return st.one_of(contents(content, content), rearranged(), rearranged(), texts(told).map(with_text))
