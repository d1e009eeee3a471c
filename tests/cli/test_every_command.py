"""Whatever the command: bad input is one line, exit code 2, and nothing is written."""

import os

import pytest

from jaxwalk import cli

OUT = {  # how each says where its results go, and what else it cannot do without
    "demo": ("--out", "x.html", []),
    "train": ("--run-dir", "x", []),
    "train-baseline": ("--run-dir", "x", ["ppo"]),
    "sweep": ("--run-dir", "x", ["--study", "s", "--set", "ddpg.gamma=0.7:0.9"]),
    "refine": ("--out", "x.safetensors", ["fixed"]),
    "evaluate": ("--json", "x.json", ["fixed"]),
    "push-map": ("--out", "x", ["fixed"]),
    "compare": ("--out", "x", ["fixed"]),
    "agreement": ("--out", "x", ["fixed"]),
    "sensitivity": ("--out", "x", ["fixed"]),
    "generalise": ("--out", "x", ["fixed"]),
    "gait": ("--out", "x", ["fixed"]),
    "report": ("--out", "x.html", ["fixed"]),
    "paper": ("--out", "x", []),
    "export": ("--out", "x", ["shipped"]),
    "render": ("--out", "x.png", ["fixed"]),
    "play": ("--out", "x.html", ["shipped"]),
    "view": (None, "", ["fixed"]),
    "ros": ("--out", "x", ["shipped"]),
    "bench": ("--json", "x.json", []),
}
NAMELESS = ("demo", "train", "train-baseline", "sweep", "paper", "bench")  # these are told no policy first


@pytest.fixture
def refused(tmp_path, capsys, monkeypatch):
    """The one line that a command line is refused with."""
    monkeypatch.chdir(tmp_path)

    def run(*argv):
        before = sorted(os.listdir(tmp_path))
        assert cli.main(list(argv)) == 2
        out, error = capsys.readouterr()
        assert out == "" and error.startswith("jaxwalk: error: ") and error.count("\n") == 1
        assert sorted(os.listdir(tmp_path)) == before
        return error

    return run


def test_all_are_here():
    assert set(OUT) == set(cli.COMMANDS)


@pytest.mark.parametrize("command", OUT)
def test_an_option_that_there_is_not(refused, command):
    assert "--nonsense" in refused(command, *OUT[command][2], "--nonsense", "1")


@pytest.mark.parametrize("command", [name for name in OUT if name not in NAMELESS])
def test_a_policy_that_there_is_not(refused, command):
    option, place, _ = OUT[command]
    assert "nobody" in refused(command, "nobody", *([option, place] if option else []))


@pytest.mark.parametrize("command", [name for name in OUT if OUT[name][0]])
def test_a_place_that_cannot_be_written_to(refused, tmp_path, command):
    option, place, more = OUT[command]
    (tmp_path / "file").write_text("in the way")
    assert "file" in refused(command, *more, option, f"file/{place}")
    assert (tmp_path / "file").read_text() == "in the way"
