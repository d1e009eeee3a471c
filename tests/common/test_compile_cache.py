"""JAX's compiled programs: what was cut short is removed, not stumbled over for ever."""

import os
import subprocess
import sys

_COMPILE = """
import sys
import jax
from jaxwalk.common import compile_cache
jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)
compile_cache.guard(compile_cache.folder())
jax.jit(lambda x: x * x + 1)(2.0)
jax.jit(lambda x: x * x + 2)(2.0)
"""


def _compiled(folder):
    done = subprocess.run(
        [sys.executable, "-c", _COMPILE], env=os.environ | {"JAX_COMPILATION_CACHE_DIR": str(folder)},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    return done.stderr


def test_entries_that_were_cut_short_are_made_anew(tmp_path):
    assert _compiled(tmp_path) == ""
    sound = {path.name: path.read_bytes() for path in tmp_path.glob("*-cache")}
    assert len(sound) >= 2
    for name, content in sound.items():
        (tmp_path / name).write_bytes(content[: len(content) // 2])
    assert _compiled(tmp_path) == ""
    healed = {path.name: path.stat().st_size for path in tmp_path.glob("*-cache")}
    assert set(healed) == set(sound)
    assert all(size > 0.9 * len(sound[name]) for name, size in healed.items())


def test_a_folder_that_takes_nothing_is_told_of_once():
    said = _compiled("/proc/1")
    assert said.startswith("jaxwalk: not all compiled programs are kept in /proc/1: ")
    assert said.count("\n") == 1
