"""Checkpoints: what is read is what was saved, and what is damaged is told and passed over."""

from __future__ import annotations

import shutil

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.common.errors import UserError
from jaxwalk.learn.train import checkpoint
from jaxwalk.learn.train.checkpoint import Checkpoint, Store


def numbered(number: int) -> Checkpoint:
    arrays = {
        "learner.w": np.random.default_rng(number).normal(size=(64, 64)).astype(np.float32),
        "size": np.array(number, np.int32),
        "key": np.array([number, 2**32 - 1], np.uint32),
    }
    return Checkpoint(arrays, {"rows": number, "score": float("nan"), "found": {"7": [1.5, None]}})


@pytest.fixture(scope="module")
def two(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run") / "resume"
    store = Store(folder, "mine")
    for number in range(4):
        store.save(numbered(number))
    store.close()
    return folder


def latest(folder, run: str = "mine"):
    """(the number of the latest checkpoint that is whole, what was said)."""
    said: list[str] = []
    store = Store(folder, run)
    try:
        found = store.latest(said.append, 2**20)
        if found is None:
            return None, said
        number = found.notes["rows"]
        assert checkpoint.digest(found) == checkpoint.digest(numbered(number))
        return number, said
    finally:
        store.close()


def test_the_latest_comes_back_and_two_are_kept(two):
    assert latest(two) == (3, [])
    assert sorted(path.name for path in two.iterdir()) == ["2", "3"]


def test_no_folder_no_checkpoint(tmp_path):
    assert latest(tmp_path / "none") == (None, [])


def _cut(data: bytes) -> bytes:
    return data[: len(data) // 2]


def _flipped(data: bytes) -> bytes:
    return bytes([*data[: len(data) // 2], data[len(data) // 2] ^ 4, *data[len(data) // 2 + 1 :]])


@pytest.mark.parametrize("harm", [_cut, _flipped])
def test_harm_to_any_file_is_seen(two, tmp_path, harm):
    names = [path.relative_to(two / "3") for path in (two / "3").rglob("*") if path.is_file()]
    seen = set()
    for i, name in enumerate(names):
        folder = shutil.copytree(two, tmp_path / str(i))
        file = folder / "3" / name
        file.write_bytes(harm(file.read_bytes() or b"\0"))
        number, said = latest(folder)  # it compares all values with those that were saved
        assert (number, len(said)) in {(3, 0), (2, 1)}
        if number == 2:
            seen.add(name.parts[0])
            assert "checkpoint 3 is damaged" in said[0] and "the one before it" in said[0]
            assert latest(folder) == (2, [])  # it was dropped
    assert {"arrays", "rest"} <= seen


def test_a_value_that_was_exchanged_is_seen(two, tmp_path, monkeypatch):
    """A checkpoint that reads well, with other values than those that its digest was made of."""
    store = Store(tmp_path, "mine")
    store.save(numbered(0), wait=True)
    with monkeypatch.context() as patch:
        patch.setattr(checkpoint, "_whole", lambda *_: "0" * 64)
        store.save(numbered(1), wait=True)
    store.close()
    number, said = latest(tmp_path)
    assert number == 0 and "its digest differs" in said[0]


def test_a_foreign_one_is_not_taken(two, tmp_path):
    store = Store(tmp_path / "other", "theirs")
    store.save(numbered(9))
    store.close()
    folder = shutil.copytree(two, tmp_path / "run")
    shutil.copytree(tmp_path / "other" / "0", folder / "8")
    (folder / "9").mkdir()
    (folder / "9" / "notes.txt").write_text("not one of ours")
    (folder / "half").write_text("")
    number, said = latest(folder)
    assert number == 3
    assert any("8 is of another run" in line for line in said)
    with pytest.raises(UserError, match=r"no checkpoint in .* can be used"):
        latest(tmp_path / "other")


def test_a_tree_comes_back_as_it_was():
    tree = {"key": jax.random.split(jax.random.key(3), 2), "x": (jnp.float32(np.nan), jnp.arange(3))}
    arrays = checkpoint.pack(tree)
    like, where = jax.eval_shape(lambda: tree), tree["x"][1].sharding
    back = checkpoint.unpack(arrays, like, where)
    assert jax.tree.structure(back) == jax.tree.structure(tree)
    again = checkpoint.pack(back)
    assert all(arrays[name].tobytes() == again[name].tobytes() for name in arrays)
    assert back["key"].dtype == tree["key"].dtype
    with pytest.raises(UserError, match=r"another version.*x\.1"):
        checkpoint.unpack(arrays | {"x.1": np.zeros(4, np.int32)}, like, where)
