"""Whether there is a browser here, and a page in it."""

from __future__ import annotations

import os
import sys
import webbrowser
from pathlib import Path


def opened(file: Path, wanted: bool) -> bool:
    """Open ``file``, if that is ``wanted`` and there is a browser; whether it was."""
    return wanted and _has_browser() and webbrowser.open(file.resolve().as_uri())


def _has_browser() -> bool:
    shown = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    if sys.platform.startswith("linux") and not shown:
        return False  # or one in the terminal would take it over
    try:
        webbrowser.get()
    except webbrowser.Error:
        return False
    return True
