"""Readings that cannot be true: the last good one is held for a stated time, then the joints are let go."""

import dataclasses
import subprocess

import numpy as np
import pytest

from jaxwalk import deploy
from jaxwalk.common import resources
from jaxwalk.common.errors import UserError
from jaxwalk.deploy import soundness
from jaxwalk.export import c, c_runtime, manifest, tensors
from jaxwalk.learn.policies import named, policy
from jaxwalk.options import checks

HOLD = soundness.hold_ticks(named.load("shipped").config.physics.timestep)
BODY = 1.8, 75.0, 1.0


def _exported(name, folder):
    trained = policy.load(resources.model_path(f"{name}.safetensors"))
    told = manifest.build(trained, named.load(name).config)
    (folder / "policy.npz").write_bytes(tensors.to_npz(trained, told))
    (folder / "policy.h").write_bytes(c.header(trained, told))
    return folder


@pytest.fixture(scope="module", params=checks.TRAINED)
def folder(request, tmp_path_factory):
    return _exported(request.param, tmp_path_factory.mktemp(request.param))


@pytest.fixture(scope="module")
def fast(folder):
    """Compiled so that no comparison knows of not-a-number."""
    return c_runtime.build(folder / "policy.h", folder, "-ffast-math", "-O3")


@pytest.fixture
def both(folder, fast):
    return deploy.Controller.load(folder / "policy.npz", *BODY), c_runtime.Controller(fast, *BODY)


def said(tick=0):
    t = 0.01 * tick
    joints = np.array([[0.3 - t, 0.1, -0.05], [-0.25 + t, 0.2 + t, 0.0]], np.float32)
    rates = np.array([[-1.0, 0.0, 0.1], [1.0, 0.5, 0.0]], np.float32)
    touch = np.array([600.0, 0.0], np.float32)
    return deploy.Sensors(np.float32(1.0 + t), 0.5, 0.05, 0.1, joints, rates, touch)


def spoilt(one, place, value):
    told = soundness.flat(one)
    told[place] = value
    return soundness.of_flat(told)


@pytest.mark.parametrize("value", [np.nan, -np.nan, np.inf, -np.inf, 1e9])
@pytest.mark.parametrize("place", range(18))
def test_any_bad_input_is_held_over_and_no_more(both, place, value):
    for runtime in both:
        runtime.start(said(), 0)
        runtime.tick(said())
    for tick in range(1, HOLD + 1):
        commands = [runtime.tick(spoilt(said(tick), place, value)) for runtime in both]
        assert np.isfinite(commands).all() and np.abs(commands[0]).max() > 0.1
        np.testing.assert_allclose(*commands, atol=0.05)
    assert not any(runtime.passive for runtime in both)
    for runtime in both:
        runtime.tick(said())  # one good reading, and all begins anew
    for _ in range(HOLD):
        commands = [runtime.tick(spoilt(said(), place, value)) for runtime in both]
    assert not any(runtime.passive for runtime in both)
    for _ in range(2):
        for runtime in both:
            let_go = runtime.tick(spoilt(said(), place, value))
            assert runtime.passive and runtime.fallen and not runtime.touchdown
            np.testing.assert_array_equal(let_go[[0, 2, 3, 5]], 0.0)
            assert set(let_go[[1, 4]]) <= {np.float32(0), *said().joints[:, 1]}
    for runtime in both:
        assert runtime.passive and not runtime.tick(said())[[0, 2, 3, 5]].any(), "until it is started again"
        runtime.start(said(), 0)
        assert not runtime.passive


def test_a_held_reading_is_as_if_it_were_told_again(both):
    for runtime in both:
        runtime.start(said(), 0)
        runtime.tick(said(1))
        held = [runtime.tick(spoilt(said(9), 2, np.nan)) for _ in range(3)]
        runtime.start(said(), 0)
        runtime.tick(said(1))
        np.testing.assert_array_equal(held, [runtime.tick(said(1)) for _ in range(3)])


def test_who_begins_with_a_bad_reading_moves_nothing(both):
    for runtime in both:
        np.testing.assert_array_equal(runtime.start(spoilt(said(), 5, np.nan), 0), 0.0)
        assert runtime.passive and runtime.fallen
        runtime.tick(said())
        assert runtime.passive


def test_shapes_and_degrees_are_refused_by_name(folder):
    controller = deploy.Controller.load(folder / "policy.npz", *BODY)
    wrong = dataclasses.replace(said(), joints=np.zeros((3, 3)))
    controller.start(said(), 0)
    for call in (lambda: controller.start(wrong, 0), lambda: controller.tick(wrong)):
        with pytest.raises(UserError, match=r"sensors' joints: give the shape \(2, 3\), not \(3, 3\)"):
            call()
    degrees = dataclasses.replace(said(), joints=np.degrees(said().joints))
    with pytest.raises(UserError, match=r"sensors' joints 17\.1.*: give radians"):
        controller.start(degrees, 0)


def test_the_header_is_cpp_without_a_warning(folder, tmp_path):
    source = tmp_path / "main.cpp"
    source.write_text(
        '#include "policy.h"\nstatic jaxwalk walker;\nint main() {\n'
        "  jaxwalk_sensors said = jaxwalk_sensors();\n  float joints[6];\n"
        "  if (jaxwalk_init(&walker, JAXWALK_HEIGHT, JAXWALK_MASS, JAXWALK_SPEED)) return 1;\n"
        "  if (jaxwalk_start(&walker, &said, 0, joints)) return 2;\n"
        "  jaxwalk_tick(&walker, &said, joints);\n"
        "  return walker.passive + jaxwalk_ask(&walker, 9.0f) + 1;\n}\n"
    )
    strict = ["-Wall", "-Wextra", "-Wpedantic", "-Werror"]
    for compiler in (["g++", "-std=c++11"], ["g++", "-std=c++20"]):
        subprocess.run(
            [*compiler, *strict, f"-I{folder}", str(source), "-o", str(tmp_path / "main")], check=True
        )
        subprocess.run([str(tmp_path / "main")], check=True)
