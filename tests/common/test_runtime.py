"""Settings of the process, each looked at from a fresh one."""

import json
import os
import subprocess
import sys

from jaxwalk.common import runtime

_REPORT = """
import json, sys
from jaxwalk.common import runtime
runtime.setup()
runtime.setup()
import jax
print(json.dumps({
    "devices": jax.local_device_count("cpu"),
    "cache": jax.config.jax_compilation_cache_dir,
    "sum": float(jax.jit(lambda x: (x * x).sum())(jax.numpy.arange(4.0))),
}))
"""


def _process(tmp_path, **environment):
    """What a process with these variables prints, XDG_CACHE_HOME being ``tmp_path``."""
    drop = ("XLA_FLAGS", "JAX_COMPILATION_CACHE_DIR", "JAX_NUM_CPU_DEVICES")
    clean = {name: value for name, value in os.environ.items() if name not in drop}
    done = subprocess.run(
        [sys.executable, "-c", _REPORT],
        env=clean | {"XDG_CACHE_HOME": str(tmp_path), "JAX_PLATFORMS": "cpu"} | environment,
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    (line,) = done.stdout.splitlines()  # and so none of MJX's about Warp
    return json.loads(line)


def test_all_cores_and_a_cache_by_default(tmp_path):
    report = _process(tmp_path)
    assert report == {
        "devices": len(os.sched_getaffinity(0)), "cache": str(tmp_path / "jaxwalk"), "sum": 14.0,
    }  # fmt: skip
    # Even a program this small is remembered.
    assert any(path.name.startswith("jit__lambda") for path in (tmp_path / "jaxwalk").iterdir())


def test_the_users_own_settings_stand(tmp_path):
    own = tmp_path / "own"
    report = _process(
        tmp_path,
        XLA_FLAGS="--xla_force_host_platform_device_count=3",
        JAX_COMPILATION_CACHE_DIR=str(own),
    )
    assert (report["devices"], report["cache"]) == (3, str(own))
    assert not (tmp_path / "jaxwalk").exists()


def test_importing_the_package_changes_nothing():
    program = (
        "import os; before = dict(os.environ); import jaxwalk, jaxwalk.cli, jaxwalk.common.runtime, sys;"
    )
    program += "assert before == dict(os.environ); assert 'jax' not in sys.modules"
    subprocess.run([sys.executable, "-c", program], check=True)


def test_the_memory_that_is_left_is_the_least_of_machine_container_and_limit(tmp_path, monkeypatch):
    whole = runtime.memory_left()
    assert 2**20 < whole < 2**50
    (tmp_path / "memory.max").write_text("5000000\n")
    (tmp_path / "memory.current").write_text("2000000\n")
    monkeypatch.setattr(runtime, "_CGROUPS", tmp_path)
    assert runtime.memory_left() == 3_000_000
    (tmp_path / "memory.max").write_text("max\n")
    assert runtime.memory_left() > 3_000_000
    monkeypatch.setattr(runtime.resource, "getrlimit", lambda which: (1000, 1000))
    assert runtime.memory_left() == 0


def test_a_containers_share_of_the_cores_is_read(tmp_path):
    for text, cores in (("max 100000", None), ("150000 100000", 1), ("400000 100000", 4), ("junk", None)):
        (tmp_path / "cpu.max").write_text(text + "\n")
        assert runtime._quota(tmp_path / "cpu.max") == cores
    assert runtime._quota(tmp_path / "none") is None
