"""Pictures are drawn under our own settings, and end no run."""

import matplotlib
import pytest

from jaxwalk.common import figures
from jaxwalk.common.errors import UserError


def test_a_picture_is_drawn_whatever_the_program_has_set(tmp_path):
    said = []
    with matplotlib.rc_context({"text.usetex": True, "font.size": 40.0}):
        with figures.spare(said.append):
            figure = figures.new_figure(2.0, 2.0)
            figure.subplots().set_title("a_b $c")
            figures.write_png(figure, tmp_path / "a.png")
        assert matplotlib.rcParams["font.size"] == 40.0
    assert said == [] and (tmp_path / "a.png").stat().st_size > 0


def test_a_name_is_no_formula(tmp_path):
    """Nor are ticks' own formulas names."""
    figure = figures.new_figure(3.0, 3.0)
    axes = figure.subplots()
    axes.set_title(r"run_$\nonsense{$")
    axes.loglog([1, 1e4], [1, 1e4])
    figures.write_png(figure, tmp_path / "a.png")
    assert axes.get_xticklabels()[2].get_parse_math()


def test_what_fails_of_it_is_told_but_for_a_full_disk(tmp_path):
    said = []
    with figures.spare(said.append):
        raise RuntimeError("no\nfont")
    assert said == ["a picture could not be drawn: no font"]
    with pytest.raises(UserError, match="cannot write"), figures.spare(said.append):
        figures.write_png(figures.new_figure(1.0, 1.0), tmp_path / "missing" / "a.png")
