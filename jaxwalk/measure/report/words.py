"""Numbers as the page says them, and the shape of what it says."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

NOTHING = "–"


@dataclass(frozen=True)
class Table:
    """A caption, a heading for each column, and rows; the first column names its row."""

    caption: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Section:
    """What one part says: sentences, the numbers behind them, and lines of a list."""

    sentences: tuple[str, ...]
    tables: tuple[Table, ...]
    points: tuple[str, ...] = ()


def percent(share: float) -> str:
    """A share in per cent, with one decimal."""
    return f"{100 * share:.1f} %"


def interval(pooled: Mapping[str, Any]) -> str:
    """A share with its interval, of `survival.pooled`."""
    return f"{percent(pooled['share'])} ({100 * pooled['low']:.1f} to {100 * pooled['high']:.1f})"


def number(value: float | None, form: str = ".3f") -> str:
    """A number in the format ``form``; a dash for None."""
    return NOTHING if value is None else f"{value:{form}}"


def reach(impulses: Sequence[float]) -> dict[str, float]:
    """The largest impulse tried each way, N s; 0: none."""
    return {"forward": max(0.0, *impulses, 0.0), "backward": max(0.0, *(-x for x in impulses), 0.0)}


def impulse(size: float | None, largest: float) -> str:
    """A threshold, N s; + where ``largest``, the end of the grid, was survived too."""
    if size is None:
        return NOTHING
    return f"{size:.4g}{'+' if 0 < largest <= size else ''}"


def both_ways(threshold: Mapping[str, float | None], largest: Mapping[str, float]) -> str:
    """A threshold each way, in words."""
    told = {way: impulse(threshold[way], largest[way]) for way in ("forward", "backward")}
    return f"{told['forward']} N s forward and {told['backward']} N s backward"


def place(height: float) -> str:
    """Where a push lands, ``height`` m above the torso's centre."""
    return "at the torso's centre" if height == 0 else f"{height:+g} m from the torso's centre"


def span(values: Sequence[float], form: str) -> str:
    """From the least to the most, or the one value that all have."""
    least, most = f"{min(values):{form}}", f"{max(values):{form}}"
    return least if least == most else f"{least} to {most}"
