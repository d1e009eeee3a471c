"""The run folder: complete, readable, never overwritten."""

import errno
import json
import re
import threading

import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.common import files
from jaxwalk.common.errors import UserError
from jaxwalk.config import Config, DDPGConfig
from jaxwalk.learn.runs import run_folder
from jaxwalk.learn.runs.events import Events
from jaxwalk.learn.runs.run_folder import RunFolder

CONFIG = Config(ddpg=DDPGConfig(gamma=0.5))


@pytest.fixture
def folder(tmp_path):
    with RunFolder.create(tmp_path / "deep" / "run", CONFIG, 3, "jaxwalk train --seed 3") as folder:
        yield folder


def test_what_was_asked_can_be_read_back(folder):
    assert run_folder.load_config(folder.path) == CONFIG
    assert run_folder.load_config(folder.path / "config.json") == CONFIG
    record = json.loads((folder.path / "config.json").read_text())
    assert (record["seed"], record["command"]) == (3, "jaxwalk train --seed 3")
    assert record["hardware"]["cores"] >= 1 and record["hardware"]["devices"]
    assert {"jaxwalk", "python", "jax", "mujoco", "mujoco-mjx", "brax", "flax", "optax"} <= set(
        record["versions"]
    )
    assert folder.checkpoints.is_dir()


def test_metrics_are_on_disk_line_by_line(folder):
    folder.log({"footsteps": 100, "train/reward": jnp.float32(1.5), "eval/score": float("nan")})
    folder.log({"footsteps": jnp.int32(200), "train/reward": np.float64(2.0)})
    # Still open: a run that is killed now keeps both lines, and half of a third does no harm.
    with (folder.path / "metrics.jsonl").open("a") as file:
        file.write('{"footsteps": 3')
    assert run_folder.read_metrics(folder.path) == [
        {"footsteps": 100, "train/reward": 1.5, "eval/score": None},
        {"footsteps": 200, "train/reward": 2.0},
    ]


def test_tensorboard_gets_the_same_numbers(folder):
    from tensorboardX.proto.event_pb2 import Event  # pyright: ignore[reportAttributeAccessIssue]
    from tensorboardX.record_writer import masked_crc32c

    folder.log({"footsteps": 100, "train/reward": 1.5})
    folder.close()
    (path,) = folder.path.glob("events.out.*")
    data, events = path.read_bytes(), []
    while data:  # length (8), its checksum (4), event, its checksum (4)
        length = int.from_bytes(data[:8], "little")
        body = data[12 : 12 + length]
        assert int.from_bytes(data[12 + length : 16 + length], "little") == masked_crc32c(body)
        events.append(Event.FromString(body))
        data = data[16 + length :]
    seen = [(e.step, v.tag, v.simple_value) for e in events for v in e.summary.value]
    assert seen == [(100, "train/reward", 1.5)]


def test_the_summary_is_replaced_whole(folder, monkeypatch):
    folder.write_summary({"survival": 0.5})
    with pytest.raises(TypeError):
        folder.write_summary({"survival": object()})
    assert json.loads((folder.path / "summary.json").read_text()) == {"survival": 0.5}
    folder.write_summary({"survival": jnp.ones(2), "worst": float("-inf")})
    assert json.loads((folder.path / "summary.json").read_text()) == {"survival": [1.0, 1.0], "worst": None}
    assert not [path for path in folder.path.iterdir() if path.name.startswith(".")]


def test_a_run_is_never_overwritten(folder):
    before = {path: path.read_bytes() for path in folder.path.iterdir() if path.is_file()}
    with pytest.raises(UserError, match=r"already holds a run.*--run-dir"):
        RunFolder.create(folder.path, Config(), 0, "jaxwalk train")
    assert {path: path.read_bytes() for path in folder.path.iterdir() if path.is_file()} == before


def test_an_empty_folder_will_do(tmp_path):
    RunFolder.create(tmp_path, Config(), 0, "").close()
    assert (tmp_path / "config.json").exists()


def test_runs_without_a_name_get_one_each(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    paths = []
    for _ in range(2):
        with RunFolder.create(None, Config(), 0, "") as folder:
            paths.append(folder.path)
    assert len(set(paths)) == 2
    for path in paths:
        assert re.fullmatch(r"runs/\d{8}-\d{6}(-\d)?", str(path))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (None, "No such file"),
        ("{", "not JSON"),
        ("[1]", "no configuration"),
        ('{"config": {"ddpg": {"gama": 1}}}', "unknown field ddpg.gama"),
    ],
)
def test_a_foreign_folder_is_named_in_one_line(tmp_path, text, says):
    if text is not None:
        (tmp_path / "config.json").write_text(text)
    with pytest.raises(UserError, match=says) as caught:
        run_folder.load_config(tmp_path)
    assert str(tmp_path) in str(caught.value) and "\n" not in str(caught.value)


def test_results_that_cannot_be_written_are_the_users_business(tmp_path):
    with pytest.raises(UserError, match="cannot write"):
        files.write_json(tmp_path / "missing" / "e.json", {})


def test_a_run_begun_from_python_can_be_gone_on_with(tmp_path):
    typed = "jaxwalk.train(config, 'run', seed=3, seeds=1)"
    with RunFolder.create(tmp_path / "run", Config(), 3, typed) as folder:
        assert run_folder.load_origin(folder.path).command == typed


def test_names_of_one_second_are_handed_out_once(tmp_path, monkeypatch):
    """To processes, too: the folder is there when its name is."""
    monkeypatch.chdir(tmp_path)
    names = [run_folder.dated() for _ in range(3)]
    assert len(set(names)) == 3 and all(name.is_dir() for name in names)


def test_who_comes_second_into_a_folder_is_told_that_it_holds_a_run(tmp_path, monkeypatch):
    with RunFolder.create(tmp_path / "run", CONFIG, 0, "first"):
        looks = iter([lambda path: None, run_folder.check_free])
        # The other began between the look and the making.
        monkeypatch.setattr(run_folder, "check_free", lambda path: next(looks)(path))
        with pytest.raises(UserError, match="already holds a run"):
            RunFolder.create(tmp_path / "run", CONFIG, 0, "second")
    assert json.loads((tmp_path / "run" / "config.json").read_text())["command"] == "first"


def test_a_folder_that_could_not_be_begun_is_as_it_was(tmp_path, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch, pytest.raises(UserError, match="No space left"):
        patch.setattr(files, "replace", full)
        RunFolder.create(tmp_path / "run", CONFIG, 0, "")
    assert list((tmp_path / "run").iterdir()) == []
    with monkeypatch.context() as patch, pytest.raises(UserError, match="No space left"):
        patch.setattr(run_folder.fcntl, "flock", full)
        RunFolder.create(tmp_path / "run", CONFIG, 0, "")
    assert list((tmp_path / "run").iterdir()) == []
    RunFolder.create(tmp_path / "run", CONFIG, 0, "").close()


def test_a_file_system_without_locks_is_told_of_and_used(tmp_path, monkeypatch, capsys):
    def missing(*_):
        raise OSError(errno.ENOSYS, "Function not implemented")

    monkeypatch.setattr(run_folder.fcntl, "flock", missing)
    with RunFolder.create(tmp_path / "run", CONFIG, 0, "") as folder:
        folder.log({"footsteps": 1})
    assert capsys.readouterr().out.startswith(f"no locks on the file system of {tmp_path / 'run'}")
    assert run_folder.read_metrics(tmp_path / "run") == [{"footsteps": 1}]


def test_no_thread_of_tensorboard_s_holds_a_run_whose_disk_is_full(folder, monkeypatch, capsys):
    def full(*_, **__):
        raise OSError(errno.ENOSPC, "No space left on device")

    before = threading.active_count()
    folder.log({"footsteps": 1, "a": 1.0})
    assert threading.active_count() == before
    monkeypatch.setattr(Events, "_write", full)
    for footsteps in range(2, 40):  # more than a queue would hold
        folder.log({"footsteps": footsteps, "a": 1.0})
    assert len(run_folder.read_metrics(folder.path)) == 39
    assert capsys.readouterr().out.count("TensorBoard gets no more") == 1


def test_events_of_a_later_process_come_later_whatever_the_clock_says(tmp_path):
    (tmp_path / "events.out.tfevents.4000000000.host").touch()
    for _ in range(2):
        events = Events(tmp_path, None)
        events.log(1, {"a": 1.0})
        events.close()
    names = sorted(path.name for path in tmp_path.iterdir())
    assert [name.split(".")[3] for name in names] == ["4000000000", "4000000001", "4000000002"]
