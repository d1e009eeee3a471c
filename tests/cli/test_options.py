"""Good command lines: what reaches the programs behind them."""

import dataclasses
import json
from pathlib import Path

import pytest

from jaxwalk.config import Config, TrainConfig, to_dict
from jaxwalk.config.presets import PRESETS
from jaxwalk.learn.train.options import read
from jaxwalk.measure.bench.setting import configured


def test_train_without_options_is_the_default_configuration(jaxwalk_cli, called):
    assert jaxwalk_cli("train") == (0, "preset default, for cpu\n", "")
    assert called == [(Config(), None, 0, "jaxwalk train")]


@pytest.mark.parametrize("there, preset", [(True, "gpu"), (False, "default")])
def test_the_preset_is_that_of_what_jax_finds(monkeypatch, there, preset):
    monkeypatch.setattr("jaxwalk.common.runtime.has_accelerator", lambda: there)
    assert read(["--seed", "3"]).config == PRESETS[preset]
    assert configured(64) == dataclasses.replace(
        PRESETS[preset],
        train=dataclasses.replace(PRESETS[preset].train, walkers=64),
        ddpg=dataclasses.replace(PRESETS[preset].ddpg, warmup=64),
    )


@pytest.mark.parametrize("spelling", [["--preset", "paper"], ["--preset=paper"]])
@pytest.mark.parametrize("first", [True, False])
def test_options_override_the_preset_wherever_it_stands(jaxwalk_cli, called, tmp_path, spelling, first):
    override = ["--ddpg.gamma", "0.5", "--observation", "speed", "pitch"]
    argv = spelling + override if first else override + spelling
    run_dir = tmp_path / "a run"
    assert jaxwalk_cli("train", *argv, "--run-dir", run_dir, "--seed", 7)[0] == 0
    paper = PRESETS["paper"]
    expected = dataclasses.replace(
        paper, ddpg=dataclasses.replace(paper.ddpg, gamma=0.5), observation=("speed", "pitch")
    )
    config, path, seed, command = called[0]
    assert (config, path, seed) == (expected, run_dir, 7)
    assert command.startswith("jaxwalk train --") and f"'{run_dir}'" in command


@pytest.fixture
def a_run(tmp_path):
    """The configuration of a run with seed 5 and 32 walkers."""
    path, config = tmp_path / "run", dataclasses.replace(Config(), train=TrainConfig(walkers=32))
    path.mkdir()
    record = {"config": to_dict(config), "seed": 5, "command": "jaxwalk train", "versions": {}}
    (path / "config.json").write_text(json.dumps(record))
    return path


@pytest.mark.parametrize("argv", [[], ["--seed", "5", "--train.walkers", "32"]])
def test_a_run_is_resumed_with_what_it_was_begun_with(jaxwalk_cli, called, a_run, argv):
    assert jaxwalk_cli("train", "--resume", a_run, *argv) == (0, "", "")
    assert called == [(a_run,)]


@pytest.mark.parametrize(
    "argv",
    [
        ["--seed", "0"],
        ["--train.walkers", "256"],
        ["--train.checkpoint-seconds", "1.0"],
        ["--preset", "default"],
        ["--run-dir", "elsewhere"],
    ],
)
def test_an_option_that_contradicts_the_run_is_named(jaxwalk_cli, called, a_run, argv):
    code, out, error = jaxwalk_cli("train", *argv, "--resume", a_run)
    assert (code, out, called, error.count("\n")) == (2, "", [], 1)
    assert f"{argv[0]} {argv[1]}" in error and str(a_run) in error


def test_what_is_no_run_is_not_resumed(jaxwalk_cli, called, tmp_path):
    code, _, error = jaxwalk_cli("train", "--resume", tmp_path)
    assert (code, called, error.count("\n")) == (2, [], 1)
    assert str(tmp_path / "config.json") in error


@pytest.mark.parametrize(
    "argv", [["--impulses", "-40,30"], ["--impulses=-40,30"], ["--impulses", " -40, 30 "]]
)
def test_an_impulse_list_may_begin_with_a_minus(jaxwalk_cli, called, argv):
    assert jaxwalk_cli("evaluate", "fixed", *argv) == (0, "", "")
    assert called[0][0].impulses == (-40.0, 30.0)


def test_evaluate_hands_on_every_option(jaxwalk_cli, called, tmp_path):
    argv = "--walkers 3 --seconds 5 --speed 0.8 --impulses 10 --phases 4 --replicas 2 --push-height -0.2"
    argv += " --push-duration 0.05 --height 1.5 --mass 50 --noise 0 --seed 9 --engine mujoco --model walls"
    argv += " --actuators exoskeleton --slope 2 --delay 0.01 --motor-strength 0.9 --push-again 1.5"
    assert jaxwalk_cli("evaluate", "shipped", *argv.split(), "--json", tmp_path / "e.json") == (0, "", "")
    assert dataclasses.asdict(called[0][0]) == {
        "policy": "shipped", "walkers": 3, "seconds": 5.0, "speed": 0.8, "impulses": (10.0,), "phases": 4,
        "replicas": 2, "push_height": -0.2, "push_duration": 0.05, "height": 1.5, "mass": 50.0, "noise": 0.0,
        "seed": 9, "engine": "mujoco", "model": "walls", "actuators": "exoskeleton",
        "slope": 2.0, "delay": 0.01, "motor_strength": 0.9, "push_again": 1.5,
        "json": tmp_path / "e.json",
    }  # fmt: skip


def test_evaluate_defaults_are_the_papers_pushes(jaxwalk_cli, called, tmp_path):
    assert jaxwalk_cli("evaluate", tmp_path)[0] == 0
    args = called[0][0]
    assert (args.walkers, args.seconds, args.speed, args.impulses) == (256, 60.0, 1.0, (30.0, -40.0))
    assert args.engine == "mjx"
    assert (args.phases, args.replicas, args.push_duration, args.noise) == (16, None, 0.1, 1.0)


def test_render_and_bench_hand_on_their_options(jaxwalk_cli, called, tmp_path):
    assert (
        jaxwalk_cli("render", "fixed", "--out", tmp_path / "w.GIF", "--push", "-40", "--height-px", 480)[0]
        == 0
    )
    assert jaxwalk_cli("bench", "--walkers", 16)[0] == 0
    (render,), (bench,) = called
    assert (render.out, render.push, render.height_px, render.height) == (
        tmp_path / "w.GIF",
        -40.0,
        480,
        None,
    )
    assert (bench.walkers, bench.json) == (16, None)


def test_every_field_of_the_configuration_is_an_option_with_help(jaxwalk_cli):
    code, text, _ = jaxwalk_cli("train", "--help")
    assert code == 0
    lines = [line.strip("│ ") for line in text.splitlines()]

    def options(config, prefix=""):
        for field in dataclasses.fields(config):
            value = getattr(config, field.name)
            name = f"{prefix}{field.name}".replace("_", "-")
            yield from options(value, name + ".") if dataclasses.is_dataclass(value) else [f"--{name}"]

    for option in options(Config()):
        (at,) = (i for i, line in enumerate(lines) if line.split() and line.split()[0].rstrip(",") == option)
        assert any(line and not line.startswith(("(", "--")) for line in lines[at + 1 : at + 3]), (
            f"no help: {option}"
        )


def test_version(jaxwalk_cli):
    from jaxwalk import __version__

    assert jaxwalk_cli("--version") == (0, f"jaxwalk {__version__}\n", "")


def test_paths_stay_paths(jaxwalk_cli, called):
    assert jaxwalk_cli("train", "--run-dir", "relative/run")[0] == 0
    assert called[0][1] == Path("relative/run")


@pytest.mark.parametrize(
    ("words", "twin", "back_step"),
    [
        ("", False, True),
        ("--ddpg.twin --gait.no-back-step", True, False),
        ("--ddpg.twin True --gait.back-step False", True, False),  # as it was written once
        ("--ddpg.twin=False --gait.back_step=True", False, True),
    ],
)
def test_a_switch_is_given_alone_or_with_a_value_as_of_old(words, twin, back_step):
    config = read(words.split()).config
    assert (config.ddpg.twin, config.gait.back_step) == (twin, back_step)


def test_a_shell_completes_commands_and_options(jaxwalk_cli):
    code, script, _ = jaxwalk_cli("completion", "bash")
    assert code == 0 and "complete -F" in script
    assert all(word in script for word in ("push-map", "--impulses", "--ddpg.gamma"))
    assert jaxwalk_cli("completion", "zsh")[0] == 0
    assert jaxwalk_cli("completion", "fish") == (
        2, "", "jaxwalk: error: jaxwalk completion: give one of bash, zsh\n",
    )  # fmt: skip


def test_a_command_ends_with_what_one_would_type_next(jaxwalk_cli, monkeypatch):
    monkeypatch.setattr("jaxwalk.cli._NEXT", {"evaluate": "push-map {policy} --out map"})
    monkeypatch.setattr("jaxwalk.options.checks.policy", lambda name: None)
    assert jaxwalk_cli("evaluate", "a run")[1] == "next: jaxwalk push-map 'a run' --out map\n"
