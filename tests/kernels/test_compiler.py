"""Libraries are made once, are whole, and are nobody else's."""

import errno
import multiprocessing
import os
import time
from pathlib import Path

import jax
import pytest

from jaxwalk.kernels import compiler, store
from jaxwalk.kernels.settings import jax_setting

ANSWER = ('extern "C" __attribute__((visibility("default"))) int answer() { return 42; }\n',)
BROKEN = ("this is no C++\n",)


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """A cache of its own."""
    before = jax_setting("jax_compilation_cache_dir")
    jax.config.update("jax_compilation_cache_dir", str(tmp_path))
    yield tmp_path / "native"
    jax.config.update("jax_compilation_cache_dir", before)


@pytest.fixture
def without_compiler(monkeypatch):
    """From now on none can be run."""

    def forbidden(*_):
        raise compiler.BuildError("compiled again")

    return lambda: monkeypatch.setattr(compiler, "_run", forbidden)


@pytest.fixture
def another(monkeypatch):
    """Makes ``CXX`` name another compiler."""

    def name(command):
        monkeypatch.setenv("CXX", command)
        compiler.compiler.cache_clear()
        compiler._made_for.cache_clear()

    yield name
    monkeypatch.undo()
    compiler.compiler.cache_clear()
    compiler._made_for.cache_clear()


def test_a_library_is_made_once(cache, without_compiler):
    assert compiler.compiled(ANSWER, "answer")() == 42
    without_compiler()
    assert compiler.compiled(ANSWER, "answer")() == 42
    with pytest.raises(compiler.BuildError, match="again"):
        compiler.compiled((ANSWER[0] + "\n",), "answer")


@pytest.mark.parametrize("what", ["cut off", "empty", "altered", "seal gone", "of a group", "of nobody"])
def test_what_lies_in_the_cache_and_cannot_be_trusted_is_made_anew(cache, what):
    compiler.compiled(ANSWER, "answer")
    (file,) = cache.glob("*.so")
    content = file.read_bytes()
    file.unlink()  # this process has it in use: it is put in place anew, not written over
    file.write_bytes(content)
    file.chmod(0o600)
    assert store._sound(file)
    if what == "cut off":
        file.write_bytes(content[:5000])
    elif what == "empty":
        file.write_bytes(b"")
    elif what == "altered":
        file.write_bytes(content + b" ")
    elif what == "seal gone":
        store._seal(file).unlink()
    elif what == "of a group":
        file.chmod(0o660)
    elif what == "of nobody":
        if os.geteuid():
            pytest.skip("only root can give files away")
        os.chown(file, 65534, 65534)
    inode = file.stat().st_ino
    assert not store._sound(file)
    assert compiler.compiled(ANSWER, "answer")() == 42
    assert store._sound(file) and file.stat().st_ino != inode


def test_a_folder_that_others_may_write_is_not_used(cache):
    cache.mkdir(parents=True)
    cache.chmod(0o777)
    assert compiler.compiled(ANSWER, "answer")() == 42
    assert not list(cache.iterdir())


def test_a_cache_that_cannot_be_written_is_done_without(cache):
    cache.parent.rmdir()
    cache.parent.write_text("a file where a folder should be")
    assert compiler.compiled(ANSWER, "answer")() == 42
    assert store.recall("any") is None
    store.kept("any", lambda: b"text", Path)
    assert store.recall("any") == b"text"


def test_what_was_compiled_and_cannot_be_loaded_is_not_kept(cache, another, tmp_path_factory):
    """A compiler that gives garbage once leaves nothing behind."""
    script = tmp_path_factory.mktemp("garbage") / "cc"
    script.write_text(
        '#!/bin/sh\ncase "$*" in *-shared*) for last; do out=$before; before=$last; done;; esac\n'
        'c++ "$@" && case "$*" in *-shared*) echo garbage > "$out";; esac; exit 0\n'
    )
    script.chmod(0o755)
    another(str(script))
    with pytest.raises(compiler.BuildError, match="cannot be loaded"):
        compiler.compiled(ANSWER, "answer")
    assert {file.suffix for file in cache.iterdir()} <= {".lock"}


def test_a_function_that_is_not_there_is_told(cache):
    with pytest.raises(compiler.BuildError, match=r"cannot be loaded.*question"):
        compiler.compiled(ANSWER, "question")


def test_a_process_that_holds_the_lock_for_ever_is_not_waited_for(cache, monkeypatch):
    monkeypatch.setattr(store, "SECONDS", 0)
    store.kept("one", lambda: b"text", Path)
    with store._alone(cache / "two.lock"):
        found = store.kept("two", lambda: b"text", Path)
    assert found.parent != cache and found.read_bytes() == b"text"


def test_a_cache_that_can_only_be_read_is_read(cache, monkeypatch, without_compiler):
    compiler.compiled(ANSWER, "answer")
    without_compiler()

    def forbidden(*_, **__):
        raise OSError("read-only file system")

    monkeypatch.setattr(os, "utime", forbidden)
    monkeypatch.setattr(store, "_alone", forbidden)
    assert compiler.compiled(ANSWER, "answer")() == 42


def test_what_is_left_of_a_failure_is_nothing(cache):
    with pytest.raises(compiler.BuildError, match=r"failed \(.*error.*; install g\+\+"):
        compiler.compiled(BROKEN, "answer")
    assert {file.suffix for file in cache.iterdir()} <= {".lock"}


@pytest.mark.parametrize(
    "command, why",
    [
        ("no-such-compiler", "CXX names no-such-compiler"),
        ("false", "does not run|failed"),
        (__file__, "CXX names"),
    ],
)
def test_a_compiler_that_is_none_is_told_in_one_line(cache, another, command, why):
    another(command)
    with pytest.raises(compiler.BuildError, match=why) as told:
        compiler.compiled(ANSWER, "answer")
    assert "\n" not in str(told.value) and "install" in str(told.value)


def test_a_compiler_that_takes_too_long_is_told_in_one_line(cache, monkeypatch):
    compiler._made_for()
    monkeypatch.setattr(compiler, "SECONDS", 0)
    with pytest.raises(compiler.BuildError, match="took more than"):
        compiler.compiled(("#include <regex>\nstd::regex x;\n",), "answer")


def _made(folder: str, found) -> None:
    jax.config.update("jax_compilation_cache_dir", folder)
    found.put(compiler.compiled(ANSWER, "answer")())


def test_of_several_processes_at_once_one_compiles(cache, another, tmp_path_factory):
    folder = tmp_path_factory.mktemp("counting")
    script = folder / "cc"
    script.write_text(f'#!/bin/sh\necho "$@" >> {folder}/calls\nexec c++ "$@"\n')
    script.chmod(0o755)
    another(str(script))
    context = multiprocessing.get_context("spawn")
    found = context.Queue()
    several = [context.Process(target=_made, args=(str(cache.parent), found)) for _ in range(3)]
    for process in several:
        process.start()
    assert [found.get(timeout=120) for _ in several] == [42] * 3
    for process in several:
        process.join()
    assert {file.suffix for file in cache.iterdir()} == {".lock", ".so", ".sha256"}
    assert sum("-shared" in line for line in (folder / "calls").read_text().splitlines()) == 1


def test_what_is_kept_is_whole(cache):
    store.kept("one", lambda: b"some text", Path)
    assert store.recall("one") == b"some text" and store.recall("never") is None
    (cache / "one").write_bytes(b"some tex")
    assert store.recall("one") is None


def test_what_nobody_uses_is_dropped_in_time(cache):
    for name, days in (("old", 100), ("young", 10)):
        store.kept(name, lambda: b"text", Path)
        for file in (cache / name, store._seal(cache / name)):
            os.utime(file, (0, time.time() - days * 86400))
    left = cache / "left.new"  # by a process that was killed
    left.write_bytes(b"te")
    os.utime(left, (0, time.time() - 86400))
    store.kept("another", lambda: b"text", Path)
    found = {file.name for file in cache.iterdir() if file.suffix != ".lock"}
    assert found == {"young", "young.sha256", "another", "another.sha256"}


def test_a_disk_that_is_full_is_done_without(cache, monkeypatch):
    """The cache holds nothing more; the folder for temporary files does."""

    def full(path, content, write=Path.write_bytes):
        if cache in path.parents:
            raise OSError(errno.ENOSPC, "No space left on device")
        return write(path, content)

    monkeypatch.setattr(Path, "write_bytes", full)
    assert compiler.compiled(ANSWER, "answer")() == 42
    assert {file.suffix for file in cache.iterdir()} <= {".lock"}
