"""Policy files: what is saved comes back bit for bit, and every bad file is one clear line."""

import json
import os
import subprocess
import sys
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import safetensors.numpy

from jaxwalk.common.errors import UserError
from jaxwalk.config import Config, DDPGConfig, to_dict
from jaxwalk.learn.ddpg import learner
from jaxwalk.learn.policies import policy

CONFIG = Config(ddpg=DDPGConfig(hidden=(8, 6)), observation=("speed", "pitch", "zmp", "step_length"))
_init = jax.jit(learner.init, static_argnums=(0, 2, 3))


@pytest.fixture(scope="module")
def state():
    start = _init(CONFIG.ddpg, jax.random.key(0), 4, (0.3, -0.4))
    rows = 2.0 + 3.0 * jax.random.normal(jax.random.key(1), (50, 4))
    return learner.observe(start, rows, jnp.ones((50,), bool))


@pytest.fixture(scope="module")
def trained(state):
    return policy.from_learner(CONFIG, state, seed=7, command="jaxwalk train", footsteps=120, score=0.5)


@pytest.fixture
def saved(trained, tmp_path):
    policy.save(trained, tmp_path / "policy.safetensors")
    return tmp_path / "policy.safetensors"


def test_round_trip_is_bit_for_bit(trained, saved):
    loaded = policy.load(saved)
    assert loaded.metadata == trained.metadata
    assert jax.tree.structure(loaded) == jax.tree.structure(trained)
    for a, b in zip(jax.tree.leaves(loaded), jax.tree.leaves(trained), strict=True):
        assert np.asarray(a).tobytes() == np.asarray(b).tobytes()
    assert json.loads(loaded.metadata.config) == json.loads(json.dumps(to_dict(CONFIG)))
    assert loaded.metadata.action_names == ("length", "duration")
    plan = CONFIG.gait.step_plan
    assert loaded.metadata.action_low == (-plan.change_length, -plan.change_duration)
    assert loaded.metadata.action_high == (plan.change_length, plan.change_duration)
    assert [p.name for p in saved.parent.iterdir()] == [saved.name], "temporary files are left"


def test_of_steps_that_are_told_its_bounds_are_those_of_the_command(state):
    gait = replace(CONFIG.gait, steps="told")
    told = policy.from_learner(
        replace(CONFIG, gait=gait), state, seed=0, command="", footsteps=0, score=None
    ).metadata
    assert told.action_low == (gait.length_min, gait.duration_min)
    assert told.action_high == (gait.length_max, gait.duration_max)


def test_acts_as_the_learner_did(state, saved):
    x = jax.random.normal(jax.random.key(2), (20, 4)) * 50.0  # some beyond the clip
    act = jax.jit(policy.act)
    with jax.numpy_rank_promotion("raise"), jax.numpy_dtype_promotion("strict"):
        np.testing.assert_array_equal(policy.act(policy.load(saved), x), learner.act(CONFIG.ddpg, state, x))
        assert act(policy.load(saved), x[0]).shape == (2,)


def test_acts_as_the_learner_did_without_normalisation():
    config = replace(CONFIG, ddpg=replace(CONFIG.ddpg, normalize_observations=False))
    state = _init(config.ddpg, jax.random.key(0), 4, (0.3, -0.4))
    plain = policy.from_learner(config, state, seed=0, command="", footsteps=0, score=None)
    x = jnp.full((4,), 1e3)
    np.testing.assert_array_equal(policy.act(plain, x), learner.act(config.ddpg, state, x))


def _rewritten(path, tensors=None, header=None, raw=None):
    """The file with some tensors or metadata fields changed (None: taken out)."""
    with safetensors.safe_open(path, framework="numpy") as file:
        meta = json.loads(file.metadata()["jaxwalk_policy"]) | (header or {})
        names = file.keys()  # the file itself cannot be iterated
        kept = {name: file.get_tensor(name) for name in names} | (tensors or {})
    text = json.dumps({k: v for k, v in meta.items() if v is not ...}) if raw is None else raw
    kept = {name: x for name, x in kept.items() if x is not None}
    safetensors.numpy.save_file(kept, path, {"jaxwalk_policy": text})


def _foreign(path):
    safetensors.numpy.save_file({"x": np.zeros(3, np.float32)}, path)


def _nan_weight():
    kernel = np.zeros((4, 8), np.float32)
    kernel[1, 2] = np.nan
    return {"actor/hidden_0/kernel": kernel}


BAD = {
    "missing": (lambda p: p.unlink(), "No such file"),
    "folder": (lambda p: (p.unlink(), p.mkdir()), "Is a directory"),
    "empty": (lambda p: p.write_bytes(b""), "safetensors"),
    "truncated": (lambda p: p.write_bytes(p.read_bytes()[:-10]), "safetensors"),
    "garbage": (lambda p: p.write_bytes(b"\xff" * 1000), "safetensors"),
    "large": (lambda p: os.truncate(p, policy.MAX_BYTES + 1), "more than"),
    "foreign": (
        lambda p: safetensors.numpy.save_file({"x": np.zeros(3, np.float32)}, p),
        "not of a jaxwalk policy",
    ),
    "shape": (lambda p: _rewritten(p, {"actor/output/bias": np.zeros(3, np.float32)}), "actor/output/bias"),
    "dtype": (lambda p: _rewritten(p, {"actor/output/bias": np.zeros(2)}), "'F64', not 'F32'"),
    "absent tensor": (lambda p: _rewritten(p, {"observation/std": None}), "observation/std"),
    "extra tensor": (lambda p: _rewritten(p, {"a\nb": np.zeros(1, np.float32)}), "too many"),
    "nan": (lambda p: _rewritten(p, _nan_weight()), "hidden_0/kernel holds numbers that are not finite"),
    "zero std": (lambda p: _rewritten(p, {"observation/std": np.zeros(4, np.float32)}), "above 0"),
    "newer": (lambda p: _rewritten(p, header={"format_version": 2}), "format 2"),
    "field absent": (lambda p: _rewritten(p, header={"hidden": ...}), "metadata"),
    "field type": (lambda p: _rewritten(p, header={"hidden": "wide"}), "metadata"),
    "field element": (lambda p: _rewritten(p, header={"action_low": ["a", "b"]}), "metadata"),
    "nan bound": (lambda p: _rewritten(p, header={"action_low": [float("nan"), 0.1]}), "NaN is no number"),
    "bounds": (lambda p: _rewritten(p, header={"action_low": [9.0, 9.0]}), "order"),
    "bound count": (lambda p: _rewritten(p, header={"action_low": [0.0]}), "number"),
    "not an object": (lambda p: _rewritten(p, raw="[1, 2]"), "metadata"),
    "deep json": (lambda p: _rewritten(p, raw="[" * 100_000), "nested"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_files_are_one_clear_line(saved, case):
    spoil, says = BAD[case]
    spoil(saved)
    with pytest.raises(UserError) as caught:
        policy.load(saved)
    message = str(caught.value)
    assert says in message and str(saved) in message and "\n" not in message
    assert message.endswith("give a policy that jaxwalk saved")


def test_element_types_that_numpy_lacks(saved):
    header = json.dumps({"x": {"dtype": "BF16", "shape": [1], "data_offsets": [0, 2]},
                         "__metadata__": {"jaxwalk_policy": "{}"}}).encode()  # fmt: skip
    saved.write_bytes(len(header).to_bytes(8, "little") + header + b"\0\0")
    with pytest.raises(UserError):
        policy.load(saved)


def test_save_says_where_it_cannot_write(trained, tmp_path):
    with pytest.raises(UserError, match="cannot be written"):
        policy.save(trained, tmp_path / "absent" / "policy.safetensors")
    (tmp_path / "folder").mkdir()
    with pytest.raises(UserError, match="cannot be written"):
        policy.save(trained, tmp_path / "folder")
    assert [p.name for p in tmp_path.iterdir()] == ["folder"]


def test_save_refuses_what_load_would_and_keeps_the_old_file(trained, saved):
    before = saved.read_bytes()
    with pytest.raises(ValueError, match="observation/mean"):
        policy.save(replace(trained, observation_mean=jnp.full((4,), jnp.nan)), saved)
    assert saved.read_bytes() == before


def test_does_not_import_mujoco():
    code = (
        "import sys, jaxwalk.learn.policies.policy;"
        "sys.exit(any(m.split('.')[0] == 'mujoco' for m in sys.modules))"
    )
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0
