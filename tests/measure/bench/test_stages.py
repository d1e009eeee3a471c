"""What a tick is made of: each stage moves the walkers as the package does, and tells all it should."""

import dataclasses
import io
import json
from functools import partial

import jax
import numpy as np
import pytest
from rich.console import Console

from jaxwalk.common.errors import UserError
from jaxwalk.config import Config
from jaxwalk.control import walker
from jaxwalk.control.person import model_of
from jaxwalk.measure.bench import batches, herd, picture, programs, scaling, setting, stages
from jaxwalk.measure.bench.options import BenchArgs
from jaxwalk.model import pushes
from jaxwalk.options.parse import parse
from jaxwalk.task.stepper import Task

SIZE = 2 * jax.device_count()


def test_curves_are_in_units_of_the_smallest_batch():
    def row(walkers, bare, c):
        limit = {"physics_steps_per_second": c}
        one = {"physics_steps_per_second": bare, "of_c_mujoco": bare / c}
        return {
            "walkers": walkers,
            "programs": {"mjx_step": one},
            "limits": {"c_mujoco": limit, "c_mujoco_converged": limit},
        }

    # The second batch's rounds met a machine half as fast, by C's rate: its bare step is twice as fast.
    told = {"batches": [row(64, 10.0, 40.0), {"walkers": 128, "skipped": "no room"}, row(256, 10.0, 20.0)]}
    assert picture.curves(told, absolute=False)["mjx_step"] == [(64, 1.0), (256, 2.0)]
    assert picture.curves(told, absolute=False)["c_mujoco"] == [(64, 4.0), (256, 4.0)]
    assert picture.curves(told, absolute=True)["mjx_step"] == [(64, 10.0), (256, 10.0)]


def test_a_call_of_a_large_batch_is_shorter():
    windows = {size: herd.windows_of(size, Config()) for size in (64, 256, 4096, 16384, 2**20)}
    assert windows[64] == windows[256] == Config().train.windows_per_report
    assert windows[256] > windows[4096] > windows[16384] >= windows[2**20] == 1


def test_a_batch_without_room_is_left_out_and_said():
    class Compiled:
        def memory_analysis(self):
            sizes = {"argument": 1, "output": 2**60, "temp": 2**60, "alias": 0}
            return type("M", (), {f"{name}_size_in_bytes": size for name, size in sizes.items()})

    said = batches._too_large(Compiled(), 1) or ""
    assert "MB are free" in said
    told = io.StringIO()
    console = Console(width=200, file=told)
    scaling.show(
        console,
        {
            "batches": [{"walkers": 7, "skipped": said}],
            "hardware": {"devices": ["cpu: cpu"], "cores": 1},
            "versions": {"jax": "0", "mujoco-mjx": "0"},
            "memory": {"peak_rss_mb": 1.0},
        },
    )
    assert "7 walkers left out: needs" in told.getvalue()


@pytest.mark.parametrize(
    ("argv", "says"),
    [
        ("--batches 64,64", "ascending numbers, each once"),
        ("--batches 256,64", "ascending numbers, each once"),
        ("--batches 0", "a whole number, 1 or more"),
        ("--batches 1.5", "give whole numbers"),
        ("--batches many", "no list of numbers"),
        ("--batches 64 --walkers 8", "leave one of the two out"),
        ("--stages True --deploy shipped", "leave --stages and --batches out"),
        ("--batches 64 --json no/where.json", "no folder no"),
    ],
)
def test_wrong_options_are_told_before_any_work(argv, says):
    with pytest.raises(UserError, match=says):
        parse(BenchArgs, argv.split(), "bench").check()


def test_a_batch_that_the_devices_cannot_share_is_refused(monkeypatch):
    monkeypatch.setattr(scaling.devices, "mesh", lambda: type("Mesh", (), {"size": 3}))
    with pytest.raises(UserError, match="--batches 64: give a multiple of the 3 devices"):
        scaling.bench(BenchArgs(batches=(63.0, 64.0)))


@pytest.mark.slow
def test_the_stages_of_one_walker_go_one_way():
    """Without noise and pushes the plant goes through the same motion, stage by stage."""
    # By XLA throughout: native code rounds otherwise, which a landing enlarges.
    config = Config(sensors=dataclasses.replace(Config().sensors, noise=0.0), kernels="off")
    task, windows = Task.of(config), 4
    ticks = windows * task.setup.window_ticks
    state = jax.jit(partial(programs.unpushed, config, task))(jax.random.key(0))
    body = state.walker
    assert body.push.start == pushes.NEVER

    def recorded(body):
        """`walker.tick`, and what it commands."""

        def tick(body, _):
            _, control, _ = walker.drive(task.setup, body)
            return walker.tick(task.setup, model_of(task.setup, body.person), body)[0], control

        return jax.lax.scan(tick, body, length=ticks)

    walked, commands = jax.jit(recorded)(body)
    ran = {
        stages.PLANT: jax.jit(partial(stages.plant_steps, task))(body, commands),
        stages.SENSORS: jax.jit(partial(stages.sensed_steps, task))(body, commands),
        stages.GAIT: jax.jit(partial(stages.controlled_ticks, task, ticks))(body),
        stages.PUSHES: jax.jit(partial(stages.body_ticks, task, windows))(body),
    }
    plants = {name: after if name == stages.PLANT else after.plant for name, after in ran.items()}
    for name, plant in plants.items():
        np.testing.assert_allclose(plant.qpos, walked.plant.qpos, atol=1e-4, err_msg=name)
        np.testing.assert_allclose(plant.qvel, walked.plant.qvel, atol=1e-2, err_msg=name)
    assert abs(walked.plant.qpos[0] - body.plant.qpos[0]) > 0.05  # they moved at all
    for name in (stages.SENSORS, stages.GAIT, stages.PUSHES):
        np.testing.assert_allclose(ran[name].estimate.speed, walked.estimate.speed, atol=1e-3, err_msg=name)
    assert ran[stages.PUSHES].tick == ran[stages.GAIT].tick == ticks


@pytest.mark.slow
def test_training_up_to_a_stage_collects_what_the_whole_of_it_does():
    """Before the first update nothing tells the loop with updates from the one without."""
    base = setting.configured(SIZE)
    config = dataclasses.replace(
        base,
        train=dataclasses.replace(base.train, windows_per_report=50),
        ddpg=dataclasses.replace(base.ddpg, warmup=10**6, normalize_observations=False),
    )
    mesh = batches.devices.mesh(SIZE)
    after = {}
    for name in (stages.POLICY, stages.REPLAY, stages.LOOP):
        state = batches.device_loop.init(config, mesh, 0)
        after[name] = stages.of_training(name, config, mesh)(state)
    whole, replay, policy = (after[name] for name in (stages.LOOP, stages.REPLAY, stages.POLICY))
    assert whole.counts.footsteps > 0 and whole.learner.updates == 0
    assert int(whole.replay.size.sum()) == whole.footsteps
    assert int(policy.replay.size.sum()) == 0
    for other in (replay, policy):
        np.testing.assert_allclose(other.counts.footsteps, whole.counts.footsteps)
        np.testing.assert_allclose(
            other.steppers.walker.plant.qpos, whole.steppers.walker.plant.qpos, atol=1e-3
        )
    np.testing.assert_allclose(replay.replay.rows.reward, whole.replay.rows.reward, atol=1e-3)
    np.testing.assert_array_equal(replay.replay.size, whole.replay.size)


@pytest.mark.slow
def test_all_stages_over_two_batches(tmp_path):
    path = tmp_path / "s.json"
    scaling.main(BenchArgs(stages=True, batches=(float(SIZE), 2.0 * SIZE), seconds=0.01, json=path))
    told = json.loads(path.read_text())
    assert list(told["stages"]) == list(stages.STAGES)
    assert [row["walkers"] for row in told["batches"]] == [SIZE, 2 * SIZE]
    for row in told["batches"]:
        assert list(row["programs"]) == list(stages.STAGES)
        for name in (stages.WINDOWS, stages.POLICY, stages.REPLAY, "training_loop"):
            assert row["programs"][name]["footsteps_per_second"] > 0
    assert path.with_suffix(".png").exists()
