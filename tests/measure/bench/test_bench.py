"""The benchmark: it runs, tells all it should, and its ratios are those of its own numbers."""

import json
from functools import partial

import jax
import numpy as np
import pytest
from rich.console import Console

from jaxwalk.config import Config
from jaxwalk.measure.bench import batches, command, programs, rounds, scaling
from jaxwalk.measure.bench.options import BenchArgs
from jaxwalk.task.stepper import Task

SIZE = 2 * jax.device_count()
BESIDE = ("mjx_step", "tick_by_xla")  # of no stage
SECONDS = 1e-9  # that no round is within: of each program the fewest


@pytest.fixture(scope="module", autouse=True)
def compiled_once():
    """By their names, which tell the size."""
    build, made = rounds.Builder.build, {}

    def remembered(self, name, function, *args):
        if name not in made:
            made[name] = build(self, name, function, *args)
        return made[name]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rounds.Builder, "build", remembered)
        yield


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    path = tmp_path_factory.mktemp("bench") / "bench.json"
    command.main(BenchArgs(walkers=SIZE, seconds=SECONDS, json=path))
    return json.loads(path.read_text())


@pytest.mark.slow
def test_every_program_is_measured(result):
    assert list(result["programs"]) == [
        "mjx_step",
        "tick_by_xla",
        "tick",
        "push_map",
        "training_loop",
        "training_loop_saving",
    ]
    for row in result["programs"].values():
        assert row["physics_steps_per_second"] > 0 and row["compile_seconds"] > 0
        assert len(row["round_seconds"]) == rounds.MIN_ROUNDS
        steps = result["walkers"] * result["ticks_per_call"]
        assert row["physics_steps_per_second"] == pytest.approx(steps / np.median(row["round_seconds"]))


@pytest.mark.slow
def test_walkers_walk_and_the_learner_learns(result):
    # A walker makes about two footsteps a second of its own time.
    for name in ("tick", "push_map", "training_loop"):
        row = result["programs"][name]
        own_seconds = row["physics_steps_per_second"] * result["config"]["physics"]["timestep"]
        assert 1.0 < row["footsteps_per_second"] / own_seconds < 4.0
    assert result["programs"]["training_loop"]["updates_per_second"] > 0


@pytest.mark.slow
def test_ratios_are_quotients(result):
    rates = {name: row["physics_steps_per_second"] for name, row in result["programs"].items()}
    assert result["ratios"] == {
        "tick_by_xla/mjx_step": rates["tick_by_xla"] / rates["mjx_step"],
        "tick/mjx_step": rates["tick"] / rates["mjx_step"],
        "push_map/mjx_step": rates["push_map"] / rates["mjx_step"],
        "training_loop/mjx_step": rates["training_loop"] / rates["mjx_step"],
    }


@pytest.mark.slow
def test_a_checkpoint_costs_what_its_rounds_take_longer(result):
    saving, alone = (
        np.array(result["programs"][name]["round_seconds"])
        for name in ("training_loop_saving", "training_loop")
    )
    told = result["checkpoint"]
    assert told["seconds"] == pytest.approx(np.median(saving - alone))
    assert told["share"] == pytest.approx(told["seconds"] / result["config"]["train"]["checkpoint_seconds"])


@pytest.mark.slow
def test_the_table_tells_no_ratio_of_what_has_none(result, capsys):
    command.show(Console(width=200), result)
    (saving,) = [line for line in capsys.readouterr().out.splitlines() if "training_loop_saving" in line]
    assert [cell.strip() for cell in saving.split("│")][3] == "-"


@pytest.mark.slow
def test_it_says_what_it_was_measured_on(result):
    assert result["hardware"]["cores"] >= 1 and "jax" in result["versions"]
    assert result["memory"]["peak_rss_mb"] > 100 and "peak_device_mb" in result["memory"]
    walkers = result["config"]["train"]["walkers"]
    assert result["options"] == {
        "walkers": walkers,
        "seconds": SECONDS,
        "stages": False,
        "batches": [],
        "seed": 0,
        "deploy": None,
    }


WITHOUT_XLA = tuple(name for name in batches.SHORT if name != rounds.BY_XLA)


@pytest.fixture(
    scope="module",
    # XLA compiles a whole walker for half a minute.
    params=[WITHOUT_XLA, pytest.param(batches.SHORT, marks=pytest.mark.slow)],
    ids=["without XLA's tick", "all"],
)
def names(request):
    return request.param


@pytest.fixture(scope="module")
def batch_folder(tmp_path_factory, names):
    path = tmp_path_factory.mktemp("batch")
    args = BenchArgs(batches=(float(SIZE),), seconds=SECONDS, json=path / "b.json")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(batches, "SHORT", names)
        scaling.main(args)
    return path


@pytest.fixture(scope="module")
def batch(batch_folder):
    return json.loads((batch_folder / "b.json").read_text())


def test_a_batch_tells_speed_memory_and_cost_of_each_program(batch, names):
    (row,) = batch["batches"]
    assert (row["walkers"], tuple(row["programs"])) == (SIZE, names)
    assert names[0] == "mjx_step" and names[-3:] == ("plant", "tick", "training_loop")
    bare = row["programs"]["mjx_step"]
    for one in row["programs"].values():
        steps = row["walkers"] * row["ticks_per_call"]
        assert one["physics_steps_per_second"] == pytest.approx(steps / np.median(one["round_seconds"]))
        assert one["of_bare"] == one["physics_steps_per_second"] / bare["physics_steps_per_second"]
        assert one["memory_bytes"]["argument"] > 0 and one["memory_bytes"]["temp"] > 0
        assert one["compile_seconds"] > 0
        # A step of nine degrees of freedom by three iterations is thousands of operations, not millions.
        assert 1e3 < one["flops_per_tick"] < 1e6 and 1e1 < one["bytes_per_tick"] < 1e8
        assert one["of_peak_flops"] > 0 and one["of_peak_bytes"] > 0
    if "tick_by_xla" in names:
        assert row["programs"]["tick_by_xla"]["flops_per_tick"] > bare["flops_per_tick"]
    # Native code leaves out what is multiplied by nought.
    assert row["programs"]["plant"]["flops_per_tick"] < row["programs"]["tick"]["flops_per_tick"]
    assert row["programs"]["tick"]["flops_per_tick"] < bare["flops_per_tick"]
    # So few walkers owe an update once in many calls.
    loop = row["programs"]["training_loop"]
    assert 0 <= loop["updates_per_second"] <= loop["footsteps_per_second"]
    others = [one for name, one in row["programs"].items() if name != "training_loop"]
    assert all(one["updates_per_second"] is None for one in others)


def test_what_a_stage_adds_is_its_time_less_that_of_the_one_before(batch):
    (row,) = batch["batches"]
    programs = row["programs"].values()
    whole = np.array(row["programs"]["training_loop"]["round_seconds"])
    stages = [one["round_seconds"] for name, one in row["programs"].items() if name not in BESIDE]
    beside = [np.array(one["round_seconds"]) for name, one in row["programs"].items() if name in BESIDE]
    rounds = [*(one / whole for one in beside), *np.diff([np.zeros_like(whole), *stages], axis=0) / whole]
    np.testing.assert_allclose([one["added_share"] for one in programs], np.median(rounds, axis=1))


def test_c_mujoco_is_the_limit_beside_it(batch):
    (row,) = batch["batches"]
    limit = row["limits"]["c_mujoco"]["physics_steps_per_second"]
    for one in row["programs"].values():
        assert one["of_c_mujoco"] == one["physics_steps_per_second"] / limit
    assert row["limits"]["c_mujoco_threads"] == jax.device_count()
    assert row["limits"]["flops_per_second_of_a_device"] > 1e8
    assert row["limits"]["bytes_per_second_of_a_device"] > 1e8


def test_it_is_shown_and_drawn(batch_folder, batch, capsys):
    scaling.show(Console(width=200), batch)
    shown = capsys.readouterr().out
    for word in ("mjx step", "training loop", "C, converged", "of peak flop/s"):
        assert word in shown
    assert (batch_folder / "b.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_the_bare_step_walks_as_the_tick_does():
    config, windows = Config(), 25
    task = Task.of(config)
    ticks = windows * task.setup.window_ticks
    start = jax.jit(partial(programs.unpushed, config, task))(jax.random.key(0))
    commands = jax.jit(partial(programs.record, task, ticks))(start)
    bare = jax.jit(partial(programs.bare_steps, config, task))(start.walker, commands)
    walked, _ = jax.jit(partial(programs.walk_ticks, task, windows))(start)
    assert not walked.terminated
    # Bare MJX keeps the derivative of a servo that is clamped, the tick does not (docs/physics.md).
    np.testing.assert_allclose(bare.qpos, walked.walker.plant.qpos, atol=0.05)
