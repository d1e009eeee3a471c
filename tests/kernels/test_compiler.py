"""Libraries are made once, are whole, and are nobody else's."""

import multiprocessing
import os
from pathlib import Path

import jax
import pytest

from jaxwalk.kernels import compiler

ANSWER = ('extern "C" __attribute__((visibility("default"))) int answer() { return 42; }\n',)
BROKEN = ("this is no C++\n",)


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """A cache of its own."""
    before = jax.config.jax_compilation_cache_dir
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
    assert compiler.library(ANSWER).answer() == 42
    without_compiler()
    assert compiler.library(ANSWER).answer() == 42
    with pytest.raises(compiler.BuildError, match="again"):
        compiler.library((ANSWER[0] + "\n",))


@pytest.mark.parametrize("what", ["cut off", "empty", "altered", "seal gone", "of a group", "of nobody"])
def test_what_lies_in_the_cache_and_cannot_be_trusted_is_made_anew(cache, what):
    compiler.library(ANSWER)
    (file,) = cache.glob("*.so")
    content = file.read_bytes()
    file.unlink()  # this process has it in use: it is put in place anew, not written over
    file.write_bytes(content)
    file.chmod(0o600)
    assert compiler._sound(file)
    if what == "cut off":
        file.write_bytes(content[:5000])
    elif what == "empty":
        file.write_bytes(b"")
    elif what == "altered":
        file.write_bytes(content + b" ")
    elif what == "seal gone":
        file.with_suffix(".sha256").unlink()
    elif what == "of a group":
        file.chmod(0o660)
    elif what == "of nobody":
        if os.geteuid():
            pytest.skip("only root can give files away")
        os.chown(file, 65534, 65534)
    inode = file.stat().st_ino
    assert not compiler._sound(file)
    assert compiler.library(ANSWER).answer() == 42
    assert compiler._sound(file) and file.stat().st_ino != inode


def test_a_folder_that_others_may_write_is_not_used(cache):
    cache.mkdir(parents=True)
    cache.chmod(0o777)
    assert compiler.library(ANSWER).answer() == 42
    assert not list(cache.iterdir())


def test_a_cache_that_cannot_be_written_is_done_without(cache):
    cache.parent.rmdir()
    cache.parent.write_text("a file where a folder should be")
    assert compiler.library(ANSWER).answer() == 42
    assert compiler.recall("any") is None
    compiler.keep("any", "text")
    assert compiler.recall("any") == "text"


def test_what_is_left_of_a_failure_is_nothing(cache):
    with pytest.raises(compiler.BuildError, match=r"failed \(.*error.*; install g\+\+"):
        compiler.library(BROKEN)
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
        compiler.library(ANSWER)
    assert "\n" not in str(told.value) and "install" in str(told.value)


def test_a_compiler_that_takes_too_long_is_told_in_one_line(cache, monkeypatch):
    compiler._made_for()
    monkeypatch.setattr(compiler, "SECONDS", 0)
    with pytest.raises(compiler.BuildError, match="took more than"):
        compiler.library(("#include <regex>\nstd::regex x;\n",))


def _made(folder: str, found) -> None:
    jax.config.update("jax_compilation_cache_dir", folder)
    found.put(compiler.library(ANSWER).answer())


def test_several_processes_at_once(cache):
    context = multiprocessing.get_context("spawn")
    found = context.Queue()
    several = [context.Process(target=_made, args=(str(cache.parent), found)) for _ in range(3)]
    for process in several:
        process.start()
    assert [found.get(timeout=120) for _ in several] == [42] * 3
    for process in several:
        process.join()
    assert {file.suffix for file in cache.iterdir()} == {".lock", ".so", ".sha256"}


def test_texts_are_kept_whole(cache):
    compiler.keep("one", "some text\nin lines")
    assert compiler.recall("one") == "some text\nin lines" and compiler.recall("two") is None
    (file,) = cache.glob("*.json")
    file.write_text(Path(file).read_text()[:-1])
    assert compiler.recall("one") is None
