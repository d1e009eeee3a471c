"""A study of trainings: shared, pruned, interrupted and failed, and what is told of it."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from pathlib import Path

import pytest

sys.path += [str(Path(__file__).parent), str(Path(__file__).parent.parent / "train")]

import canned
import small

from jaxwalk import cli
from jaxwalk.learn.runs import run_folder
from jaxwalk.learn.sweep import options as sweep_cli
from jaxwalk.learn.train import run

GAMMA = "ddpg.gamma=0.2:0.8"


@pytest.fixture
def sweep(tmp_path, capsys):
    """Runs a sweep of canned trainings; gives (exit code, what sweep.json tells, standard error)."""

    def run(*argv: str, space: str = GAMMA, folder: Path = tmp_path / "s", study: str = "s"):
        code = canned.sweep("--set", space, "--study", study, "--run-dir", str(folder), *argv)
        file = folder / "sweep.json"
        return code, json.loads(file.read_text()) if file.exists() else {}, capsys.readouterr().err

    return run


def states(told) -> list[str]:
    return [trial["state"] for trial in told["trials"]]


def test_it_finds_the_best_and_tells_of_all(sweep, tmp_path):
    code, told, error = sweep("--trials", "12", "--pruner", "none")
    assert (code, error) == (0, "")
    assert states(told) == ["complete"] * 12
    scores = {trial["trial"]: trial["score"] for trial in told["trials"]}
    for trial in told["trials"]:
        gamma = trial["values"]["ddpg.gamma"]
        assert 0.2 <= gamma <= 0.8 and trial["score"] == pytest.approx(canned.score(gamma))
        assert trial["evaluations"] == {str(i): trial["score"] for i in (1, 2, 3)}
        assert (tmp_path / "s" / trial["folder"] / "summary.json").exists()
    assert told["best"][0]["score"] == max(scores.values())
    assert told["importance"] == {"ddpg.gamma": pytest.approx(1.0)}
    rows = list(csv.DictReader((tmp_path / "s" / "sweep.csv").open()))
    assert [float(row["score"]) for row in rows] == pytest.approx(list(scores.values()))
    assert (tmp_path / "s" / "sweep.png").read_bytes().startswith(b"\x89PNG")


def test_a_journal_whose_last_line_was_cut_short_is_gone_on_with(sweep, tmp_path):
    sweep("--trials", "2")
    journal = tmp_path / "s" / "study.journal"
    journal.write_bytes(journal.read_bytes()[:-5])  # a kill, a full disk
    for trials in (3, 4):
        code, told, error = sweep("--trials", str(trials))
        assert (code, error) == (0, "")
        assert states(told).count("complete") == trials


def test_a_study_is_gone_on_with_to_the_number_that_it_shall_have(sweep):
    assert len(sweep("--trials", "2")[1]["trials"]) == 2
    code, told, _ = sweep("--trials", "3")
    assert code == 0 and len(told["trials"]) == 3
    assert len({trial["values"]["ddpg.gamma"] for trial in told["trials"]}) == 3
    assert len(sweep("--trials", "3")[1]["trials"]) == 3


def test_the_same_seed_draws_the_same(sweep, tmp_path):
    drawn = []
    for name, seed in (("a", "1"), ("b", "1"), ("c", "2")):
        _, told, _ = sweep("--trials", "3", "--seed", seed, folder=tmp_path / name)
        drawn.append([trial["values"] for trial in told["trials"]])
    assert drawn[0] == drawn[1] != drawn[2]


def test_a_trial_that_is_worse_than_the_others_is_pruned(sweep, tmp_path):
    # Five good ones, then a value that cannot be as good.
    sweep("--trials", "5", space="ddpg.gamma=0.5,0.501,0.8")
    _, told, _ = sweep("--trials", "16", space="ddpg.gamma=0.5,0.501,0.8")
    later = [trial for trial in told["trials"][5:] if trial["values"]["ddpg.gamma"] == "0.8"]
    assert later and all(trial["state"] == "pruned" for trial in later)
    assert all(len(trial["evaluations"]) < 3 for trial in later)
    assert len(told["trials"]) == 16  # pruned ones are finished, too
    assert all(row["values"]["ddpg.gamma"] != "0.8" for row in told["best"][:3])


def test_a_failed_trial_does_not_stop_the_study(sweep):
    code, told, _ = sweep("--trials", "4", "--pruner", "none", space="ddpg.gamma=0.5,0.95")
    assert code == 0 and states(told).count("complete") == 4
    failed = [trial for trial in told["trials"] if trial["state"] == "failed"]
    assert failed and all(trial["error"] == "training diverged" for trial in failed)
    assert told["states"]["failed"] == len(failed)


def test_what_always_fails_ends_in_one_line(sweep):
    code, told, error = sweep("--trials", "4", space="ddpg.gamma=0.91:0.99")
    assert code == 2 and error.count("\n") == 1
    assert "5 trials in a row failed, the last one so: training diverged" in error
    assert states(told) == ["failed"] * 5


def test_an_interrupted_trial_ends_the_sweep_and_leaves_the_study_usable(sweep):
    code, told, error = sweep("--trials", "3", space="ddpg.gamma=0.01:0.09")
    assert (code, states(told), error) == (0, ["failed"], "")
    assert "interrupted" in told["trials"][0]["error"]
    assert states(sweep("--trials", "3", space="ddpg.gamma=0.01:0.09")[1]) == ["failed"] * 2


def test_two_processes_share_one_study(tmp_path):
    program = str(Path(canned.__file__))
    argv = ["--set", GAMMA, "--study", "s", "--run-dir", str(tmp_path), "--trials", "12", "--pruner", "none"]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    both = [subprocess.Popen([sys.executable, program, *argv], **pipes) for _ in range(2)]
    for process in both:
        assert process.stdout is not None and "ready\n" in iter(process.stdout.readline, "")
    for process in both:
        assert process.stdin is not None
        process.stdin.write("\n")
        process.stdin.flush()
    said = [process.communicate()[0] for process in both]
    assert [process.returncode for process in both] == [0, 0], said
    assert canned.sweep(*argv) == 0
    told = json.loads((tmp_path / "sweep.json").read_text())
    # Each may finish the one that it is at.
    assert set(states(told)) == {"complete"} and 12 <= len(told["trials"]) <= 13
    assert len({trial["values"]["ddpg.gamma"] for trial in told["trials"]}) == len(told["trials"])
    own = [{line.split(":")[0] for line in text.splitlines() if ": score" in line} for text in said]
    assert own[0] and own[1] and not own[0] & own[1]


@pytest.mark.parametrize(
    ("argv", "told"),
    [
        (["--set", "ddpg.gamma=0.2:0.7"], "was begun with other --set"),
        (["--set", GAMMA, "--seed", "1"], "was begun with other --seed"),
        (["--set", GAMMA, "--ddpg.tau", "0.1"], "was begun with other options of train"),
    ],
)
def test_another_search_does_not_mix_in(sweep, tmp_path, capsys, argv, told):
    before = sweep("--trials", "1")[1]["trials"]
    code = canned.sweep(*argv, "--study", "s", "--run-dir", str(tmp_path / "s"), "--trials", "2")
    error = capsys.readouterr().err
    assert code == 2 and told in error and error.count("\n") == 1
    assert sweep("--trials", "1")[1]["trials"] == before


@pytest.mark.parametrize(
    ("argv", "told"),
    [
        (["--storage", "sqlite:////nowhere/at/all.db"], "cannot be used"),
        (["--storage", "postgresql://localhost:1/none"], "cannot be used"),
        (["--storage", "nonsense://x"], "cannot be used"),
        (["--study", "../up"], "a name that a folder can have"),
        (["--trials", "0"], "give a whole number, 1 or more"),
        (["--pruner", "shears"], "--pruner"),
        (["--set", "ddpg.gamma=2:3"], "give a number from 0"),
        (["--run-dir", "/proc/none"], "--run-dir"),
    ],
)
def test_bad_input_is_one_line(tmp_path, capsys, argv, told):
    given = {"--set": GAMMA, "--study": "s", "--run-dir": str(tmp_path / "s"), "--trials": "1"}
    given[argv[0]] = argv[1]
    code = canned.sweep(*(word for pair in given.items() for word in pair))
    error = capsys.readouterr().err
    assert code == 2 and error.count("\n") == 1 and told in error
    assert not list(tmp_path.rglob("sweep.json"))


def test_no_password_is_told(tmp_path, capsys):
    argv = ["--set", GAMMA, "--study", "s", "--run-dir", str(tmp_path)]
    assert canned.sweep(*argv, "--storage", "postgresql://me:secret@localhost:1/none") == 2
    said = capsys.readouterr().err
    assert "postgresql://me:***@localhost" in said and "secret" not in said
    assert canned.sweep(*argv, "--storage", "postgresql://me@localhost:1/none?password=secret&x=1") == 2
    said = capsys.readouterr().err
    assert "?password=***&x=1" in said and "secret" not in said


def test_without_optuna_it_says_how_to_get_it(capsys, monkeypatch):
    monkeypatch.setattr(sweep_cli, "find_spec", lambda name: None)
    assert cli.main(["sweep", "--set", GAMMA, "--study", "s"]) == 2
    assert "pip install 'jaxwalk[sweep]'" in capsys.readouterr().err


@pytest.mark.slow
def test_real_trainings(tmp_path, monkeypatch):
    small.shorten(monkeypatch.setattr)
    small.undrawn(monkeypatch.setattr)
    short = ["--train.footsteps", "60", "--train.windows-per-report", "20", "--ddpg.warmup", "16"]
    argv = ["--set", "train.evaluations=1,2", "--study", "real", "--run-dir", str(tmp_path), "--trials", "1"]
    assert cli.main(["sweep", "--preset", "smoke", *short, *argv]) == 0
    (trial,) = json.loads((tmp_path / "sweep.json").read_text())["trials"]
    folder = tmp_path / "trial-0000"
    assert trial["score"] == run_folder.read_summary(folder)["best"]["score"]
    assert trial["evaluations"] or trial["values"]["train.evaluations"] == "1"
    assert run_folder.load_config(folder).train.evaluations == int(trial["values"]["train.evaluations"])


@pytest.mark.slow
def test_a_training_ends_when_its_watch_says_so(tmp_path, monkeypatch):
    small.shorten(monkeypatch.setattr)
    small.undrawn(monkeypatch.setattr)
    seen = []

    def watch(footsteps, found):
        seen.append((footsteps, found.score))
        return footsteps > 0

    run.run(small.CONFIG, tmp_path / "run", 3, "jaxwalk train", watch)
    rows = [row for row in run_folder.read_metrics(tmp_path / "run") if "eval/score" in row]
    assert seen == [(row["footsteps"], row["eval/score"]) for row in rows] and len(seen) == 2
    assert run_folder.read_summary(tmp_path / "run")["interrupted"]
