"""Pictures: made without a display, and how they reach their files."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Callable, Iterator
from pathlib import Path

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text

from jaxwalk.common import files
from jaxwalk.common.errors import UserError


def new_figure(width: float, height: float) -> Figure:
    """A figure of so many inches that needs no display."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def write_png(figure: Figure, path: Path) -> None:
    """Replace ``path`` by the picture, all at once.

    Raises:
      UserError: it cannot be written.
    """
    files.write_bytes(path, png(figure))


@contextlib.contextmanager
def spare(say: Callable[[str], None]) -> Iterator[None]:
    """Within it a picture is drawn under our own settings, and what fails of it ends no run.

    Args:
      say: is told of what failed.

    Raises:
      UserError: it cannot be written.
    """
    try:
        with matplotlib.rc_context():
            matplotlib.rcdefaults()  # a program that calls us may have others
            yield
    except UserError:
        raise
    except Exception as error:  # fonts, styles, memory
        say(f"a picture could not be drawn: {' '.join(str(error).split())[:200]}")


def png(figure: Figure) -> bytes:
    """The picture as a PNG file's content."""
    for text in figure.findobj(Text):
        # A user's name is no formula, whatever dollars are in it; matplotlib's own tick labels are.
        if isinstance(text, Text) and (said := text.get_text()) and "\\math" not in said:
            text.set_parse_math(False)
    content = io.BytesIO()
    figure.savefig(content, dpi=110, format="png")
    return content.getvalue()
