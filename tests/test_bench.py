"""The benchmark: it runs, tells all it should, and its ratios are those of its own numbers."""

import json
from functools import partial

import jax
import numpy as np
import pytest
from rich.console import Console

from jaxwalk.bench import command, programs, rounds
from jaxwalk.cli.bench import BenchArgs
from jaxwalk.config import Config
from jaxwalk.stepper import Task


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    path = tmp_path_factory.mktemp("bench") / "bench.json"
    command.main(BenchArgs(walkers=2 * jax.device_count(), seconds=0.01, json=path))
    return json.loads(path.read_text())


def test_every_program_is_measured(result):
    assert list(result["programs"]) == [
        "mjx_step",
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


def test_walkers_walk_and_the_learner_learns(result):
    # A walker makes about two footsteps a second of its own time.
    for name in ("tick", "push_map", "training_loop"):
        row = result["programs"][name]
        own_seconds = row["physics_steps_per_second"] * result["config"]["physics"]["timestep"]
        assert 1.0 < row["footsteps_per_second"] / own_seconds < 4.0
    assert result["programs"]["training_loop"]["updates_per_second"] > 0


def test_ratios_are_quotients(result):
    rates = {name: row["physics_steps_per_second"] for name, row in result["programs"].items()}
    assert result["ratios"] == {
        "tick/mjx_step": rates["tick"] / rates["mjx_step"],
        "push_map/mjx_step": rates["push_map"] / rates["mjx_step"],
        "training_loop/mjx_step": rates["training_loop"] / rates["mjx_step"],
    }


def test_a_checkpoint_costs_what_its_rounds_take_longer(result):
    saving, alone = (
        np.array(result["programs"][name]["round_seconds"])
        for name in ("training_loop_saving", "training_loop")
    )
    told = result["checkpoint"]
    assert told["seconds"] == pytest.approx(np.median(saving - alone))
    assert told["share"] == pytest.approx(told["seconds"] / result["config"]["train"]["checkpoint_seconds"])


def test_the_table_tells_no_ratio_of_what_has_none(result, capsys):
    command.show(Console(width=200), result)
    (saving,) = [line for line in capsys.readouterr().out.splitlines() if "training_loop_saving" in line]
    assert [cell.strip() for cell in saving.split("│")][3] == "-"


def test_it_says_what_it_was_measured_on(result):
    assert result["hardware"]["cores"] >= 1 and "jax" in result["versions"]
    assert result["memory"]["peak_rss_mb"] > 100 and "peak_device_mb" in result["memory"]
    walkers = result["config"]["train"]["walkers"]
    assert result["options"] == {
        "walkers": walkers,
        "seconds": 0.01,
        "stages": False,
        "batches": [],
        "seed": 0,
        "deploy": None,
    }


@pytest.mark.slow
def test_the_bare_step_goes_through_the_motion_of_the_tick():
    config, windows = Config(), 25
    task = Task.of(config)
    ticks = windows * task.setup.window_ticks
    start = jax.jit(partial(programs.spawn, config, task))(jax.random.key(0))
    commands = jax.jit(partial(programs.record, task, ticks))(start)
    bare = jax.jit(partial(programs.bare_steps, config, task))(start.walker, commands)
    walked, _ = jax.jit(partial(programs.walk_ticks, task, windows))(start)
    assert not walked.terminated
    # Three programs round differently; half a second of walking enlarges that little.
    np.testing.assert_allclose(bare.qpos, walked.walker.plant.qpos, atol=1e-4)
