"""Exports: every format says what JAX says, carries its manifest, and survives nothing that is bad."""

import json
import subprocess
import zipfile
from dataclasses import replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk import cli, deploy
from jaxwalk.common import resources
from jaxwalk.common.errors import UserError
from jaxwalk.config import CompliantConfig, Config, StepPlanConfig
from jaxwalk.config.formats import of_dict
from jaxwalk.config.gait import RIGID, SHARED
from jaxwalk.deploy import person
from jaxwalk.deploy.file import MANIFEST
from jaxwalk.export import c, command, manifest, selftest, stablehlo
from jaxwalk.learn.ddpg import networks
from jaxwalk.learn.policies import named, policy

FORMATS = ("safetensors", "npz", "onnx", "stablehlo", "c")


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """(policy, manifest, file by format)."""
    trained, told = command.load("shipped")
    return trained, told, command.write(trained, told, FORMATS, tmp_path_factory.mktemp("export"))


@pytest.fixture(scope="module")
def planned():
    """(policy, manifest) of steps that are planned."""
    config = Config()
    actor = networks.init_actor(config.ddpg.hidden, jax.random.key(0), 6, (0.3, -0.4))
    trained = policy.of_parts(
        config, actor, jnp.zeros(6), jnp.ones(6), clip=10.0, seed=0, command="", footsteps=0, score=None
    )
    return trained, manifest.build(trained, config)


@pytest.fixture(scope="module")
def told():
    """The manifest of steps that the policy commands: of the shipped one, were it told so."""
    trained = command.load("shipped")[0]
    config = named.load("shipped").config
    gait = replace(config.gait, steps="told")
    low, high = gait.answers
    metadata = replace(trained.metadata, action_low=low, action_high=high)
    return manifest.build(replace(trained, metadata=metadata), replace(config, gait=gait))


@pytest.mark.parametrize("kind", FORMATS)
def test_formats_agree_on_10000_random_observations(exported, kind):
    trained, _, files = exported
    seen = command.observations(trained, 10_000)
    expected = np.asarray(jax.jit(policy.act)(policy.without_origin(trained), seen))
    actions, commands = selftest.outputs(kind, files[kind], seen)
    low, high = np.array(trained.metadata.action_low), np.array(trained.metadata.action_high)
    # In [-1, 1] JAX itself is up to 5e-6 from the same sums in doubles, to either side of which others fall.
    np.testing.assert_allclose(actions, expected, rtol=0, atol=1e-5)
    np.testing.assert_allclose(commands, low + (expected + 1) / 2 * (high - low), rtol=0, atol=1e-5)


def test_every_file_carries_the_manifest(exported):
    _, told, files = exported
    onnx = pytest.importorskip("onnx")
    model = onnx.load(files["onnx"])
    found = {
        "safetensors": deploy.load(files["safetensors"]).manifest,
        "npz": deploy.load(files["npz"]).manifest,
        "onnx": json.loads({p.key: p.value for p in model.metadata_props}[MANIFEST]),
        "stablehlo": json.loads(zipfile.ZipFile(files["stablehlo"]).read("manifest.json")),
    }
    for kind, carried in found.items():
        assert carried == told, kind
    low, high = named.load("shipped").config.gait.answers
    assert told["action"][0] == {"name": "length", "unit": "m", "low": low[0], "high": high[0]}
    assert [one["name"] for one in told["observation"]][:3] == ["speed", "speed_desired", "pitch"]
    header = files["c"].read_text()
    for one in told["observation"] + told["action"]:
        assert f'{{"{one["name"]}", "{one["unit"]}"}}' in header


def test_numbers_scale_as_dynamic_similarity_says(exported):
    numbers = exported[1]["numbers"]
    powers = {name: (one["length"], one["mass"]) for name, one in numbers.items()}
    assert powers["length_min"] == (1, 0) and powers["duration_min"] == (0.5, 0)
    assert powers["compliant_push_off_gain"] == (0.5, 1) and powers["torso_inertia"] == (2, 1)
    assert powers["compliant_swing_knee"] == (0, 0) and powers["ankle_damping"] == (1.5, 1)
    legs = {f"compliant_{name}" for name in CompliantConfig.__dataclass_fields__}
    assert legs < set(numbers) and set(SHARED) < set(numbers)


def test_a_plan_carries_its_numbers_and_what_may_be_changed_of_it(planned):
    trained, told = planned
    assert (told["switches"]["steps"], told["decisions"]["replan"]) == ("planned", Config().task.replan)
    own = Config().gait.step_plan
    assert [(one["low"], one["high"]) for one in told["action"]] == [
        (-own.change_length, own.change_length),
        (-own.change_duration, own.change_duration),
    ]
    numbers = {name: one for name, one in told["numbers"].items() if name.startswith("plan_")}
    assert set(numbers) == {f"plan_{name}" for name in StepPlanConfig.__dataclass_fields__}
    assert {name: one["value"] for name, one in numbers.items()} == {
        f"plan_{name}": value for name, value in vars(own).items()
    }
    powers = {name[5:]: (one["length"], one["mass"]) for name, one in numbers.items()}
    assert powers["change_length"] == powers["pitch_gain"] == (1, 0)
    assert powers["change_duration"] == powers["back_speed"] == (0.5, 0)
    assert powers["duration_gain"] == (-0.5, 0) and powers["length_gain"] == powers["back_gain"] == (0, 0)
    assert "#define JAXWALK_PLANNED 1" in c.header(trained, told).decode()


def test_steps_that_are_told_need_no_plan(exported, told):
    """As of files of before, which lack its numbers and the switch."""
    assert told["switches"]["steps"] == "told"
    before = told | {
        "switches": {name: x for name, x in told["switches"].items() if name != "steps"},
        "numbers": {name: x for name, x in told["numbers"].items() if not name.startswith("plan_")},
    }
    who = person.build(before)
    assert who.gait.steps == "told"
    assert np.isclose(who.gait.length_max, told["action"][0]["high"])
    with pytest.raises(KeyError, match="plan_"):
        person.build(before | {"switches": before["switches"] | {"steps": "planned"}})


def test_files_of_before_mean_what_configurations_of_their_time_do(planned):
    _, told = planned
    later = [name for name in told["numbers"] if name in person._LATER]
    later += [f"compliant_back_{name}" for name in person._AS_SWING]
    assert len(later) == len(person._LATER) + 4
    kept = {name: x for name, x in told["numbers"].items() if name not in later}
    who = person.build(told | {"numbers": kept}).gait
    swing = {f"swing_{x}": told["numbers"][f"compliant_swing_{x}"]["value"] for x in person._AS_SWING}
    then = of_dict({"format": 2, "gait": {"compliant": swing}}).gait
    for name in later:
        part, own = ("compliant", name[10:]) if name.startswith("compliant_") else ("step_plan", name[5:])
        if own not in ("ankle_end", "speed_usual"):  # where the stop, and all that a speed changes, are 0
            assert getattr(getattr(who, part), own) == pytest.approx(getattr(getattr(then, part), own)), name


def test_rigid_legs_carry_their_own_numbers():
    _, told = command.load("shipped-rigid")
    assert set(RIGID) < set(told["numbers"]) and told["numbers"]["toe_off_gain"]["length"] == 0.5
    assert not any(name.startswith(("compliant_", "plan_")) for name in told["numbers"])
    assert told["switches"]["steps"] == "told"
    assert (told["switches"]["form"], told["decisions"]["replan"], told["strength"]) == ("rigid", 0, None)


def test_the_safetensors_export_is_a_policy_file_too(exported):
    trained, _, files = exported
    assert policy.load(files["safetensors"]).metadata == trained.metadata


def test_stablehlo_is_for_cpu_and_cuda_and_any_batch(exported):
    program = stablehlo.load(exported[2]["stablehlo"])
    assert set(program.platforms) == {"cpu", "cuda"}
    assert not isinstance(program.in_avals[0].shape[0], int)
    for batch in (1, 7):
        actions, _ = stablehlo.run(
            exported[2]["stablehlo"], np.zeros((batch, len(exported[0].observation_mean)), np.float32)
        )
        assert actions.shape == (batch, 2)


def test_fresh_processes_verify_what_is_good_and_tell_what_is_not(exported, tmp_path):
    trained, told, _ = exported
    files = command.write(trained, told, ("npz", "c"), tmp_path)
    assert selftest.in_fresh_process("npz", files["npz"])["commands"] < selftest.TOLERANCE
    program = selftest.compile_c(tmp_path / selftest.C_TEST, tmp_path / "selftest")
    assert subprocess.run([program], capture_output=True).returncode == 0
    other = replace(trained, observation_mean=trained.observation_mean + 0.01)
    files["npz"].write_bytes(command.tensors.to_npz(other, told))
    with pytest.raises(UserError, match="differ from JAX"):
        selftest.in_fresh_process("npz", files["npz"])
    files["c"].write_bytes(command.c.header(other, told))
    program = selftest.compile_c(tmp_path / selftest.C_TEST, tmp_path / "selftest")
    assert subprocess.run([program], capture_output=True).returncode == 1


BAD = {
    "format": (["shipped", "--out", "x", "--format", "tflite"], "give one or more of safetensors"),
    "twice": (["shipped", "--out", "x", "--format", "c,c"], "once"),
    "rule": (["raibert", "--out", "x"], "a rule, not trained"),
    "absent": (["nowhere", "--out", "x"], "no policy"),
    "file for a folder": (["shipped", "--out", "FILE"], "not a folder"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line(case, tmp_path, monkeypatch, capsys):
    argv, says = BAD[case]
    monkeypatch.chdir(tmp_path)
    (tmp_path / "FILE").write_text("kept")
    assert cli.main(["export", *argv]) == 2
    said = capsys.readouterr().err
    assert says in said and said.count("\n") == 1
    assert [p.name for p in tmp_path.iterdir()] == ["FILE"] and (tmp_path / "FILE").read_text() == "kept"


def _cut(path):
    path.write_bytes(path.read_bytes()[:-100])


SPOILT = {
    "missing": lambda p: p.unlink(),
    "folder": lambda p: (p.unlink(), p.mkdir()),
    "empty": lambda p: p.write_bytes(b""),
    "cut": _cut,
    "garbage": lambda p: p.write_bytes(b"\xff" * 1000),
    "a policy of another kind": lambda p: p.write_bytes(
        resources.model_path("shipped.safetensors").read_bytes()
    ),
}


@pytest.mark.parametrize("kind", ["safetensors", "npz"])
@pytest.mark.parametrize("case", SPOILT)
def test_the_runtime_refuses_bad_files_in_one_line(exported, tmp_path, case, kind):
    path = tmp_path / f"policy.{kind}"
    path.write_bytes(exported[2][kind].read_bytes())
    SPOILT[case](path)
    with pytest.raises(UserError) as caught:
        deploy.load(path)
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["actor/output/bias", "observation/mean"])
def test_the_runtime_refuses_tensors_of_more_dimensions(exported, tmp_path, name):
    with np.load(exported[2]["npz"]) as kept:
        parts: dict[str, Any] = dict(kept)
    assert name in parts
    parts[name] = np.tile(parts[name], (len(parts[name]), 1))
    np.savez(tmp_path / "policy.npz", **parts)
    with pytest.raises(UserError, match="its tensors are damaged"):
        deploy.load(tmp_path / "policy.npz")


def test_the_runtime_refuses_what_is_newer(exported, tmp_path):
    trained, told, _ = exported
    path = tmp_path / "policy.npz"
    path.write_bytes(command.tensors.to_npz(trained, told | {"format_version": 99}))
    with pytest.raises(UserError, match="format 99"):
        deploy.load(path)


def test_the_latency_table_has_every_format(capsys, tmp_path):
    path = tmp_path / "latency.json"
    argv = ["bench", "--deploy", "shipped", "--seconds", "0.01", "--json", str(path)]
    assert cli.main(argv) == 0, capsys.readouterr().err
    rows = json.loads(path.read_text())["formats"]
    assert set(rows) == {"jax", *FORMATS}
    assert all(row["decision_us"] > 0 for row in rows.values())
    assert {kind for kind, row in rows.items() if row["tick_us"]} == {"safetensors", "npz", "c"}
    assert {kind for kind, row in rows.items() if row["bytes"]} == set(FORMATS)
