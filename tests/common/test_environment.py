"""What the environment holds of JAX's settings: it changes no number, and what does not work is one line."""

import os
import subprocess
import sys

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.common import environment, runtime
from jaxwalk.common.errors import UserError
from jaxwalk.task.env import FootstepEnv

_SET_UP = """
import sys
from jaxwalk.common import environment, runtime
from jaxwalk.common.errors import UserError
try:
    runtime.setup()
    environment.start_devices()
except UserError as error:
    sys.exit(f"told: {error}")
import jax, matplotlib
print(jax.numpy.arange(2.0).dtype, jax.random.key(0).dtype, matplotlib.rcParams["text.usetex"])
"""


def _process(tmp_path, **settings):
    return subprocess.run(
        [sys.executable, "-c", _SET_UP], env=os.environ | {"XDG_CACHE_HOME": str(tmp_path)} | settings,
        capture_output=True, text=True, check=False,
    )  # fmt: skip


def test_numbers_and_pictures_are_as_without_it(tmp_path):
    own = tmp_path / "matplotlibrc"
    own.write_text("text.usetex : True\n")
    done = _process(
        tmp_path, JAX_ENABLE_X64="1", JAX_DEFAULT_PRNG_IMPL="rbg", JAX_NUMPY_DTYPE_PROMOTION="nonsense",
        MPLBACKEND="nonsense", MATPLOTLIBRC=str(own),
    )  # fmt: skip
    assert (done.stdout, done.stderr) == ("float32 key<fry> False\n", "")


@pytest.mark.parametrize(
    ("name", "value", "says"),
    [
        ("JAX_PLATFORMS", "nonsense", "JAX_PLATFORMS=cpu"),
        ("JAX_NUM_CPU_DEVICES", "two", "leave it unset"),
        ("MUJOCO_GL", "nonsense", "leave it unset"),
    ],
)
def test_what_does_not_work_is_one_line_that_names_it(tmp_path, name, value, says):
    said = _process(tmp_path, **{name: value}).stderr
    assert said.startswith("told: ") and said.count("\n") == 1
    assert f"{name}={value}" in said and says in said


def test_a_fault_of_nobody_s_setting_stays_a_fault(monkeypatch):
    monkeypatch.setenv("JAX_SOMETHING", "1")
    with pytest.raises(ValueError, match="no matter"), environment.told("JAX"):
        raise ValueError("no matter of settings")
    with pytest.raises(UserError, match="JAX_SOMETHING=1"), environment.told("JAX"):
        raise ValueError("of jax_something")


def test_an_environment_of_brax_walks_in_float32_whatever_the_process_has_set():
    env = FootstepEnv()
    with runtime.as_ours():
        before = jax.eval_shape(env.reset, jax.random.key(0))
    with jax.enable_x64(True), jax.numpy_dtype_promotion("strict"):
        state = jax.eval_shape(env.reset, jax.random.key(0))
        after = jax.eval_shape(env.step, state, jnp.zeros(2))
    assert str(before) == str(state) == str(after)


def test_our_settings_are_this_block_s_alone():
    with jax.enable_x64(True), jax.default_prng_impl("rbg"):
        with runtime.as_ours():
            assert jnp.asarray(np.zeros(2)).dtype == jnp.float32
            assert "fry" in str(jax.random.key(0).dtype)
        assert jnp.asarray(np.zeros(2)).dtype == jnp.float64
