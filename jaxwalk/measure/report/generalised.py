"""What the numbers of other bodies, loads, floors, sensors and speeds say."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from jaxwalk.measure.compare.verdicts import WAYS
from jaxwalk.measure.generalise.picture import LABELS
from jaxwalk.measure.report.words import Section, Table, impulse, interval, number, percent, reach, span
from jaxwalk.measure.survival import SURVIVED

_HEADER = (
    "circumstance (* its own)", "never fell", "speed, m/s", "of that asked",
    "pushes survived (95 % interval)", "forward, N s", "N s/kg", "backward, N s", "N s/kg",
)  # fmt: skip


def generalise(result: dict[str, Any]) -> Section:
    """What the results of ``jaxwalk generalise`` say."""
    rows = result["rows"]
    names = list(dict.fromkeys(row["policy"] for row in rows))
    each = {name: [row for row in rows if row["policy"] == name] for name in names}
    kinds = len({row["kind"] for row in rows})
    sentences = (
        f"{len(each[names[0]])} circumstances of {kinds} kinds, each changed alone, the policy frozen; "
        f"pushes grow with the body. {' '.join(_told(name, each[name]) for name in names)}",
    )
    tables = tuple(
        Table(
            f"{name}. Thresholds over all phases (+: the grid ends there).",
            _HEADER,
            tuple(map(_cells, each[name])),
        )
        for name in names
    )
    return Section(sentences, tables)


def _told(name: str, rows: Sequence[dict[str, Any]]) -> str:
    up = sum(row["never_fell"]["share"] >= SURVIVED for row in rows)
    least = min(rows, key=lambda row: row["pushes_survived"]["share"])
    shares = [100 * row["pushes_survived"]["share"] for row in rows]
    return (
        f"Unpushed, {100 * SURVIVED:g} % of the walkers of {name} stay up in {up} of {len(rows)}; of the "
        f"pushes they survive {span(shares, '.1f')} % (least with {_circumstance(least)})."
    )


def _circumstance(row: dict[str, Any]) -> str:
    words, _, unit = LABELS[row["kind"]].partition(", ")
    return f"{words} {row['value']:g}{' ' if unit else ''}{unit}{' *' if row['own'] else ''}"


def _cells(row: dict[str, Any]) -> tuple[str, ...]:
    largest, sizes = reach(row["impulses"]), []
    for way in WAYS:
        sizes += [impulse(row["threshold"][way], largest[way]), number(row["threshold_per_kg"][way], ".2f")]
    return (
        _circumstance(row),
        percent(row["never_fell"]["share"]),
        number(row["walking"]["speed_mean"]),
        number(row["speed_ratio"], ".2f"),
        interval(row["pushes_survived"]),
        *sizes,
    )
