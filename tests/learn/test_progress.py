"""Progress without a terminal, and the curves of a run."""

import itertools

import pytest

from jaxwalk.learn.runs import picture, progress
from jaxwalk.learn.runs.progress import Progress

ROW = {
    "train/footsteps_per_second": 512.4,
    "train/reward": 12.345,
    "train/falls_per_100": 0.5,
}


def test_plain_lines_are_few_and_say_everything(monkeypatch, capsys):
    clock = itertools.count(step=4)  # s between updates
    monkeypatch.setattr(progress.time, "monotonic", lambda: float(next(clock)))
    with Progress(8_000) as shown:
        for footsteps in range(1_000, 9_000, 1_000):
            shown.update(footsteps, ROW)
        shown.note("evaluation: [all] survive")
    lines = capsys.readouterr().out.splitlines()
    # At 0, 12, 24 s, and at the end; 1,000 footsteps take 4 s.
    assert [line.partition("  ")[0] for line in lines[:-1]] == [
        "1,000 of 8,000 footsteps",
        "4,000 of 8,000 footsteps, 0:16 left",
        "7,000 of 8,000 footsteps, 0:04 left",
        "8,000 of 8,000 footsteps, 0:00 left",
    ]
    figures = "footsteps/s 512  reward 12.35  falls/100 0.50"
    assert lines[0].endswith(figures.replace("12.35", f"{12.345:.2f}"))
    assert lines[-1] == "evaluation: [all] survive"


def test_a_terminal_gets_a_bar(monkeypatch):
    import io

    from rich.console import Console

    screen = io.StringIO()
    monkeypatch.setattr(
        progress,
        "Console",
        lambda file: Console(file=screen, force_terminal=True, width=80, legacy_windows=False),
    )
    with Progress(8_000) as shown:
        shown.update(4_000, ROW)
        shown.note("evaluation: [all] survive")
    text = screen.getvalue()
    for part in (
        "50%",
        "4,000 of 8,000 footsteps",
        "reward 12.3",
        "evaluation: [all] survive",
    ):
        assert part in text


@pytest.mark.parametrize(
    "rows", [[], [{"footsteps": 1, "train/reward": None}], [{"footsteps": n, **ROW} for n in (1, 2)]]
)
def test_curves_are_drawn_from_whatever_rows_there_are(tmp_path, rows):
    from matplotlib.image import imread

    path = tmp_path / "training.png"
    picture.training_png(rows, path)
    height, width = imread(path).shape[:2]
    assert height > 500 and width > 1000


def test_a_metric_leaves_its_mark_on_the_picture(tmp_path):
    rows = [{"footsteps": 1, "eval/survival": 0.2}, {"footsteps": 2, "eval/survival": 0.9}]
    picture.training_png([], tmp_path / "empty.png")
    picture.training_png(rows, tmp_path / "full.png")
    assert (tmp_path / "empty.png").read_bytes() != (tmp_path / "full.png").read_bytes()
