"""Pictures: made without a display, and how they reach their files."""

from __future__ import annotations

import io
from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from jaxwalk.common import files


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


def png(figure: Figure) -> bytes:
    """The picture as a PNG file's content."""
    content = io.BytesIO()
    figure.savefig(content, dpi=110, format="png")
    return content.getvalue()
