"""Bad command lines: one line, exit code 2, and nothing done."""

import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest

from jaxwalk import cli
from jaxwalk.measure.bench.options import BenchArgs

BAD = [
    ([], ["no command", "train"]),
    (["trian"], ["unknown command 'trian'", "did you mean train?"]),
    (["train", "--ddpg.gama", "0.9"], ["--ddpg.gama", "perhaps you meant --ddpg.gamma"]),
    (["train", "--ddpg.gamma", "much"], ["--ddpg.gamma", "'much'", "FLOAT"]),
    (["train", "--ddpg.gamma"], ["--ddpg.gamma", "Missing value"]),
    (["train", "--ddpg.gamma", "1"], ["--ddpg.gamma 1", "a number from 0 up to, not including, 1"]),
    (["train", "--ddpg.actor-lr", "nan"], ["--ddpg.actor-lr", "finite"]),
    (["train", "--ddpg.hidden", "64", "0"], ["--ddpg.hidden 64 0", "above 0"]),
    (
        ["train", "--ddpg.batch-size", "512", "--ddpg.replay-capacity", "100"],
        ["--ddpg.batch-size 512", "100"],
    ),
    (["train", "--train.walkers", "0"], ["--train.walkers 0", "above 0"]),
    (["train", "--observation", "mood"], ["'mood'", "--observation", "'pitch'"]),
    (["train", "--observation", "speed", "speed"], ["--observation", "each once"]),
    (["train", "--preset", "best"], ["'best' is none of default, gpu, quick, paper, smoke, rigid"]),
    (["evaluate", "fixed", "--model", "best"], ["--model", "'best' is none of planar, walls"]),
    (["evaluate", "fixed", "--replicas", "2.5"], ["--replicas", "'2.5'", "INT"]),
    (
        ["export", "shipped", "--out", "x", "--verify", "maybe"],
        ["--verify maybe: is a switch", "--no-verify"],
    ),
    (["evaluate", "fixed", "--walkers", "4000000000"], ["--walkers 4000000000: more than the memory holds"]),
    (["push-map", "fixed", "--out", "x", "--replicas", "4000000000"], ["--replicas", "more than the memory"]),
    (["train", "--train.walkers", "4000000000"], ["--train.walkers 4000000000", "give", "at most"]),
    (["train", "--body.mass", "-5"], ["mass -5", "between 5 and 500 kg"]),
    (["train", "--seed", "-1"], ["--seed -1", "0 to 4294967295"]),
    (["train", "surplus"], ["surplus"]),
    (["evaluate"], ["POLICY", "run folder", "'shipped'"]),
    (["evaluate", "missing/policy"], ["'missing/policy'", "run folder", "shipped"]),
    (["evaluate", "fixed", "--impulses", "strong"], ["--impulses", "'strong'", "30,-40"]),
    (["evaluate", "fixed", "--impulses", "-40,,30"], ["--impulses", "'-40,,30'", "30,-40"]),
    (["evaluate", "fixed", "--impulses", "inf"], ["--impulses", "'inf'", "30,-40"]),
    (["evaluate", "fixed", "--mass", "-3"], ["mass -3", "between 5 and 500 kg"]),
    (["evaluate", "fixed", "--mass", "0"], ["mass 0", "between 5 and 500 kg"]),
    (["evaluate", "fixed", "--walkers", "2.5"], ["--walkers", "'2.5'", "INT"]),
    (["evaluate", "fixed", "--engine", "bullet"], ["'bullet'", "--engine", "'mjx'", "'mujoco'"]),
    (["push-map", "fixed", "--out", "no/map", "--engine", "bullet"], ["'bullet'", "--engine", "'mujoco'"]),
    (["evaluate", "fixed", "--noise", "-1"], ["--noise -1", "0 to 100"]),
    (["evaluate", "fixed", "--push-duration", "0"], ["--push-duration 0", "give 0.001 to 2 s"]),
    (["evaluate", "fixed", "--json", "no/such/folder/e.json"], ["--json", "no folder no/such/folder"]),
    (["render", "fixed"], ["--out"]),
    (["render", "fixed", "--out", "walk.avi"], ["--out walk.avi", ".mp4, .gif, .png"]),
    (
        ["render", "fixed", "--out", "walk.gif", "--push", "30", "--push-time", "99"],
        ["--push-time 99", "--seconds"],
    ),
    (["gait", "fixed"], ["--out"]),
    (["view"], ["POLICY", "run folder"]),
    (["view", "nobody"], ["no policy 'nobody'", "shipped"]),
    (["view", "fixed", "--speed", "9"], ["--speed 9", "0.1 to 3 m/s"]),
    (["view", "fixed", "--mass", "2"], ["mass 2", "between 5 and 500 kg"]),
    (["view", "fixed", "--noise", "-1"], ["--noise -1", "0 to 100"]),
    (["view", "fixed", "--seed", "-1"], ["--seed -1", "0 to 4294967295"]),
    (["bench", "--seconds", "0"], ["--seconds 0", "above 0"]),
    (["bench", "--batches", "64,64"], ["--batches 64,64", "each once"]),
    (["evaluate", "fixed", "--seconds", "3"], ["--seconds 3", "5 to 3600"]),
    (["evaluate", "fixed", "--seed", "99999999999999999999"], ["--seed 9999", "0 to 4294967295"]),
    (["sensitivity", "fixed", "--out", "x", "--iterations", "1e30"], ["--iterations 1e+30", "1 to 1000"]),
    (["train-baseline", "sac", "--footsteps", "4050"], ["--warmup 4000", "--footsteps, 4050"]),
]


@pytest.mark.parametrize(("argv", "says"), BAD, ids=lambda x: " ".join(x) if isinstance(x, list) else None)
def test_bad_input_is_one_line_that_says_what_would_be_right(jaxwalk_cli, called, argv, says):
    code, out, error = jaxwalk_cli(*argv)
    assert (code, out, called) == (2, "", [])
    assert error.startswith("jaxwalk: error: ")
    assert error.endswith("\n") and error.count("\n") == 1
    assert not set(error) & set("│╭─╰")
    for part in says:
        assert part in error


@pytest.mark.parametrize("held", ["config.json", "policy.safetensors", "metrics.jsonl"])
def test_a_run_folder_with_a_run_in_it_is_left_alone(jaxwalk_cli, called, tmp_path, held):
    (tmp_path / held).write_text("precious")
    code, _, error = jaxwalk_cli("train", "--run-dir", tmp_path)
    assert (code, called) == (2, [])
    assert str(tmp_path) in error and held in error and "--run-dir" in error
    assert [path.name for path in tmp_path.iterdir()] == [held]
    assert (tmp_path / held).read_text() == "precious"


def test_a_run_folder_that_cannot_be_made(jaxwalk_cli, called, tmp_path):
    (tmp_path / "file").touch()
    code, _, error = jaxwalk_cli("train", "--run-dir", tmp_path / "file" / "run")
    assert (code, called, error.count("\n")) == (2, [], 1)
    assert f"{tmp_path / 'file'} is not a folder" in error and "--run-dir" in error


def test_results_are_not_written_over_a_folder(jaxwalk_cli, called, tmp_path):
    code, _, error = jaxwalk_cli("evaluate", "fixed", "--json", tmp_path)
    assert (code, called) == (2, [])
    assert "--json" in error and "name a file" in error


@pytest.mark.parametrize(
    "argv",
    [
        ["evaluate", "LONG"], ["view", "LONG"], ["compare", "fixed", "LONG", "--out", "x"],
        ["evaluate", "fixed", "--json", "LONG"], ["evaluate", "fixed", "--json", "LONG/x.json"],
        ["render", "fixed", "--out", "LONG.png"], ["evaluate", "fixed", "--json", "a\nb/x.json"],
    ],
    ids=lambda argv: ascii(" ".join(argv)),
)  # fmt: skip
def test_paths_that_no_file_system_takes(jaxwalk_cli, called, argv):
    code, out, error = jaxwalk_cli(*(part.replace("LONG", "a" * 300) for part in argv))
    assert (code, out, called) == (2, "", [])
    assert error.startswith("jaxwalk: error: ") and error.count("\n") == 1


def test_an_export_does_not_replace_a_run_s_policy(jaxwalk_cli, tmp_path):
    (tmp_path / "config.json").write_text("{}")
    (tmp_path / "policy.safetensors").write_bytes(b"precious")
    code, _, error = jaxwalk_cli("export", "shipped", "--out", tmp_path)
    assert code == 2 and "already holds a run" in error and "--out" in error
    assert (tmp_path / "policy.safetensors").read_bytes() == b"precious"


def test_an_export_replaces_an_earlier_one(jaxwalk_cli, tmp_path):
    for _ in range(2):
        code, _, error = jaxwalk_cli("export", "shipped", "--out", tmp_path / "[/x]*?")
        assert (code, error) == (0, "")
    (tmp_path / "[/x]*?" / "config.json").write_text("{}")  # a run that somebody exported into
    assert jaxwalk_cli("export", "shipped", "--out", tmp_path / "[/x]*?")[0] == 2


def test_ctrl_c_is_one_line_and_130(jaxwalk_cli, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(sys.modules["jaxwalk.measure.bench.command"], "main", interrupted)
    assert jaxwalk_cli("bench") == (130, "", "jaxwalk: interrupted\n")


@pytest.mark.parametrize("argv", [["--help"], ["train", "--help"], ["trian"]])
def test_a_full_disk_behind_the_output_is_one_line(argv):
    """And behind standard error: nothing to read, but no other code."""
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "jaxwalk", *argv],
            stdout=full, stderr=full if argv == ["trian"] else subprocess.PIPE, check=False,
        )  # fmt: skip
    assert done.returncode == 2
    if done.stderr is not None:
        assert done.stderr.startswith(b"jaxwalk: error: cannot write standard output: No space left")
        assert done.stderr.count(b"\n") == 1


def test_the_picture_of_batches_does_not_replace_their_numbers(jaxwalk_cli, called, tmp_path):
    code, _, error = jaxwalk_cli("bench", "--batches", "2,4", "--json", tmp_path / "b.png")
    assert (code, called) == (2, []) and "give one with .json" in error
    assert BenchArgs(batches=(2.0,), json=Path(os.devnull)).picture() is None


@pytest.mark.parametrize("terminal", [True, False])
@pytest.mark.parametrize(
    "locale", [{"PYTHONUTF8": "1"}, {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}]
)
def test_the_program_itself_exits_with_2_and_no_traceback(terminal, locale):
    """On a terminal or none, in any locale: the parser underneath draws differently in each."""
    ours, theirs = pty.openpty()
    done = subprocess.run(
        [sys.executable, "-m", "jaxwalk", "train", "--ddpg.gama", "1"],
        stdout=theirs if terminal else subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=os.environ | {"TERM": "xterm-256color"} | locale,
        check=False,
    )
    os.close(ours)
    os.close(theirs)
    said = "Unrecognized options: --ddpg.gama, 1; perhaps you meant --ddpg.gamma; see jaxwalk train --help"
    assert (done.returncode, done.stderr.decode()) == (2, f"jaxwalk: error: {said}\n")


@pytest.mark.parametrize("argv", [["--help"], *([name, "--help"] for name in cli.COMMANDS)])
def test_help_imports_nothing_heavy(argv):
    """What makes --help answer at once, without the noise of a timing."""
    program = (
        "import sys; from jaxwalk.cli import main; code = main(sys.argv[1:]);"
        "heavy = {'jax', 'numpy', 'mujoco', 'brax', 'flax', 'matplotlib', 'tensorboardX'} & set(sys.modules);"
        "sys.exit(f'imported {heavy}' if heavy else code)"
    )
    done = subprocess.run([sys.executable, "-c", program, *argv], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("usage: jaxwalk")
