"""Pictures: they are there, of the size asked for, and show a walker, its push and its fall."""

import subprocess
from dataclasses import replace
from functools import partial
from typing import Any

import imageio.v2 as imageio
import mujoco
import numpy as np
import pytest

from jaxwalk.common.errors import UserError
from jaxwalk.config import Config
from jaxwalk.show import recording, scene
from jaxwalk.show.recording import Shove, Walk
from jaxwalk.show.render import command
from jaxwalk.show.render.options import RenderArgs
from jaxwalk.show.scene import Stage

STANDING = np.array([0.0, 0.952, 0.05, 0.35, 0.0, -0.3, -0.25, 0.0, 0.3])


@pytest.fixture(scope="module")
def model():
    return scene.model(Config())


@pytest.fixture(scope="module")
def stage_of(model):
    """Makes a stage of a given size; skips where nothing can draw."""
    try:
        Stage(model, 1.8, 16, 16).__exit__()
    except UserError as error:
        pytest.skip(str(error))
    return partial(Stage, model, 1.8)


@pytest.fixture
def walk():
    """One pose carried along at 1 m/s for 1.2 s, pushed from 0.5 to 0.6 s."""
    qpos = np.tile(STANDING, (601, 1))
    qpos[:, 0] = np.arange(601) * 0.002
    return Walk(qpos, 0.002, (Shove(30.0, 0.5),), None, np.ones(601), ())


def _args(out, **changes):
    settings: dict[str, Any] = dict(seconds=1.2, width=320, height_px=120, push=30.0, push_time=0.5, fps=10)
    return RenderArgs(policy="fixed", out=out, **(settings | changes))


def _reds(picture):
    red, green, blue = np.asarray(picture, int)[..., :3].transpose(2, 0, 1)
    return int(((red > 150) & (green < 80) & (blue < 90)).sum())


def test_poses_are_evenly_spaced_and_one_shows_the_push():
    np.testing.assert_allclose(command.pose_times(8.0, 5, None), [0, 2, 4, 6, 8])
    for middle in (0.0, 0.3, 3.05, 7.9, 8.0):
        times = command.pose_times(8.0, 7, middle)
        assert times[0] >= 0 and times[-1] <= 8.0 and np.abs(times - middle).min() < 1e-9
        np.testing.assert_allclose(np.diff(times), times[1] - times[0], atol=1e-9)


def test_the_camera_follows_without_lag(walk):
    np.testing.assert_allclose(recording.camera_path(walk), walk.qpos[:, 0], atol=1e-6)


def test_strip(walk, stage_of, tmp_path):
    out = tmp_path / "walk.png"
    command._write_strip(out, walk, stage_of, _args(out))
    picture = imageio.imread(out)
    assert picture.shape == (120, 320, 3) and picture.std() > 20
    plain = replace(walk, pushes=())
    command._write_strip(out, plain, stage_of, _args(out, push=0.0))
    assert _reds(picture) > 50 > 5 > _reds(imageio.imread(out)), "no push to be seen, or one that was none"


@pytest.mark.parametrize("name", ["walk.mp4", "walk.gif"])
def test_film(walk, stage_of, tmp_path, name):
    out = tmp_path / name
    command._write_film(out, walk, stage_of, _args(out))
    frames = np.stack(imageio.mimread(out))[..., :3]
    assert frames.shape == (13, 120, 320, 3) and frames.std(axis=(1, 2, 3)).min() > 20
    assert _reds(frames[6]) > 50 > _reds(frames[2]), "the arrow is drawn while it acts"
    assert np.abs(np.diff(frames.astype(int), axis=0)).max(axis=(1, 2, 3)).min() > 20, "a still picture"


def test_the_fallen_lie_on_the_floor(model):
    pose = STANDING + np.array([0, 0, 0.8, 0, 0, 0, 0, 0, 0])
    fall = recording.collapse(model, pose, np.zeros(9), 1000)
    assert np.isfinite(fall).all()
    assert 0.0 < fall[-1, 1] < 0.5, "hip neither up nor below the floor"
    assert np.abs(fall[-1] - fall[-100]).max() < 0.1, "still moving after 2 s"


def test_the_limp_body_weighs_what_the_walker_does(model):
    assert mujoco.mj_getTotalmass(model) == pytest.approx(75.0)


def test_the_command_draws_a_real_walk(stage_of, tmp_path, capsys):
    out = tmp_path / "walk.png"
    out.write_bytes(b"old")
    command.main(_args(out, seconds=1.0, push=0.0))
    assert imageio.imread(out).shape == (120, 320, 3)
    assert [path.name for path in tmp_path.iterdir()] == [out.name], "temporary files are left"
    assert "1.0 s" in capsys.readouterr().out


def test_no_opengl_is_one_line_that_says_what_to_install(monkeypatch):
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    monkeypatch.setattr(scene.sys, "platform", "linux")
    monkeypatch.setattr(subprocess, "run", lambda *a, **k: subprocess.CompletedProcess(a, 1))
    with pytest.raises(UserError, match=r"install libegl1 or libosmesa6") as caught:
        scene.choose_backend()
    assert "\n" not in str(caught.value)


def test_a_folder_that_is_gone_is_one_line(monkeypatch, walk, tmp_path):
    monkeypatch.setattr(scene, "choose_backend", lambda: None)
    monkeypatch.setattr(recording, "record", lambda *_: walk)
    with pytest.raises(UserError, match=r"cannot write .*absent"):
        command.main(_args(tmp_path / "absent" / "walk.png"))


def test_an_ffmpeg_without_the_encoder_is_one_line_with_the_cure(tmp_path, monkeypatch):
    fake = tmp_path / "ffmpeg"
    fake.write_text("#!/bin/sh\necho ' V..... mpeg4'\n")
    fake.chmod(0o755)
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", str(fake))
    assert "lacks libx264; unset IMAGEIO_FFMPEG_EXE" in command._encoder("much\nelse")
    fake.write_text("#!/bin/sh\necho ' V..... libx264'\n")
    assert command._encoder("the first\nof many") == "the first"
