"""The numbers at the top of the page, with ``fixed``, the step that is never adapted, beside them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from jaxwalk.learn.policies.named import FIXED, Subject
from jaxwalk.measure.compare.verdicts import WAYS
from jaxwalk.measure.report import collect
from jaxwalk.measure.report.options import Name
from jaxwalk.measure.report.words import NOTHING, Table, impulse, number, percent, reach

_ROWS = {
    "speed, m/s": "speed",
    "never fell, unpushed": "survival_unpushed",
    **{
        f"push survived {way}, {where.replace('_', ' ')}, N s": f"{where}_{way}"
        for where in ("all_phases", "worst_phase")
        for way in WAYS
    },
}


def table(found: Mapping[Name, dict[str, Any]], subject: Subject) -> Table | None:
    """The numbers, out of the comparison, where both met the same trials, or of the evaluation; else None."""
    if "compare" in found:
        result = found["compare"]
        members = collect.members(result)
        own = next((one for one in members if one["policy_digest"] == subject.digest), None)
        fixed = next((one for one in members if one["policy"] == FIXED), None)
        sides = [None if one is None else one["figures"] for one in (own, fixed)]
        largest, how = result["reach"], result["options"]
    elif "evaluate" in found and "pushes" in found["evaluate"]:
        result = found["evaluate"]
        figures = {
            "speed": result["walking"]["speed_mean"],
            "survival_unpushed": result["walking"]["survival"],
        }
        for where, name in (("all_phases", "threshold"), ("worst_phase", "threshold_worst_phase")):
            figures |= {f"{where}_{way}": result[name][way] for way in WAYS}
        sides, largest, how = [figures, None], reach(result["pushes"]["impulses"]), result["options"]
    else:
        return None
    if subject.name == FIXED:
        sides = sides[:1]
    caption = (
        f"{how['walkers']} walkers for {how['seconds']:g} s; the largest push that 95 % survive, with all "
        f"smaller ones, {how['replicas']} walkers at each of {how['phases']} phases of the step (+: the grid "
        "ends there)."
    )
    rows = tuple(
        (title, *(_told(side, figure, largest) for side in sides)) for title, figure in _ROWS.items()
    )
    return Table(caption, ("", subject.name, FIXED)[: 1 + len(sides)], rows)


def _told(figures: dict[str, Any] | None, figure: str, largest: Mapping[str, float]) -> str:
    if figures is None:
        return NOTHING
    value = figures[figure]
    if figure == "speed":
        return number(value)
    if figure == "survival_unpushed":
        return percent(value)
    return impulse(value, largest[figure.rpartition("_")[2]])
