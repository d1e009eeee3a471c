"""What the numbers of sensitivity, agreement, gait and speed say."""

from __future__ import annotations

from typing import Any

from jaxwalk.measure.agreement.differences import WALKING
from jaxwalk.measure.bench.rounds import BARE
from jaxwalk.measure.compare.verdicts import WAYS
from jaxwalk.measure.report.words import (
    NOTHING,
    Section,
    Table,
    impulse,
    interval,
    number,
    percent,
    reach,
    span,
)

_PHYSICS = {  # of `sensitivity`: words, the unit that values are shown in, and its name
    "timestep": ("time step", 1e-3, " ms"),
    "iterations": ("solver iterations", 1, ""),
    "contact_timeconst": ("contact time constant", 1e-3, " ms"),
    "friction": ("friction", 1, ""),
}


def sensitivity(result: dict[str, Any]) -> Section:
    """What the results of ``jaxwalk sensitivity`` say."""
    rows, largest = result["rows"], reach(result["options"]["impulses"])

    def setting(row: dict[str, Any]) -> str:
        name, unit, shown = _PHYSICS[row["parameter"]]
        return f"{name} {row['value'] / unit:g}{shown}{' *' if row['own'] else ''}"

    def sizes(way: str) -> str:
        known = [row["threshold"][way] for row in rows if row["threshold"][way] is not None]
        return f"{span(known, '.4g')} N s {way}" if known else f"untried {way}"

    pushed = [row["pushes_survived"]["share"] for row in rows]
    lowest = min(rows, key=lambda row: row["pushes_survived"]["share"])
    sentences = (
        f"Each setting of the physics is changed alone. Over {len(rows)} rows the speed is "
        f"{span([row['walking']['speed_mean'] for row in rows], '.3f')} m/s; of the pushes are survived "
        f"{span([100 * share for share in pushed], '.1f')} % (least with {setting(lowest)}).",
        f"Thresholds: {sizes('forward')}, {sizes('backward')}.",
    )
    table = Table(
        "* the policy's own setting. Thresholds in N s (+: the grid ends there).",
        ("setting", "never fell", "speed, m/s", "step, m", "pushes survived (95 % interval)",
         "forward", "backward"),
        tuple(
            (
                setting(row),
                percent(row["never_fell"]["share"]),
                number(row["walking"]["speed_mean"]),
                number(row["walking"]["step_length_mean"]),
                interval(row["pushes_survived"]),
                *(impulse(row["threshold"][way], largest[way]) for way in WAYS),
            )
            for row in rows
        ),
    )  # fmt: skip
    return Section(sentences, (table,))


_BESIDE = {
    "mujoco": "C MuJoCo (doubles, solved to convergence)",
    "ode": "ODE (its world step)",
    "ode-quick": "ODE (its quick step)",
}


def agreement(result: dict[str, Any]) -> Section:
    """What the results of ``jaxwalk agreement`` say."""
    engines, cells, largest = result["engines"], result["cells"], reach(result["cells"]["impulses"])
    names = list(engines)
    difference, error = result["walking"]["speed_mean"], result["walking"]["speed_standard_error"]
    count = len(cells["impulses"]) * len(cells["phases"])
    sentences = (
        "The same starts, noise and pushes in MJX (single precision, few iterations) and in "
        f"{_BESIDE[names[1]]}: the 95 % intervals of survival overlap in "
        f"{percent(cells['share_overlapping'])} of {count} cells of impulse and phase; the largest "
        f"difference of a cell is {100 * cells['largest_difference']:.0f} points.",
        f"The speeds differ by {difference:+.4f} m/s; chance alone has a standard error of {error:.4f} m/s.",
    )
    rows = [
        (
            key.replace("_", " "),
            *(number(engines[name]["walking"][key], ".4f") for name in names),
            f"{result['walking'][key]:+.4f}",
        )
        for key in WALKING
    ]
    rows += [
        (
            f"threshold {way}, N s",
            *(impulse(engines[name]["threshold"][way], largest[way]) for name in names),
            NOTHING,
        )
        for way in WAYS
    ]
    first, second = result["pushes"]
    rows.append(
        (
            "all pushes survived (95 % interval)",
            interval(first),
            interval(second),
            f"{100 * (second['share'] - first['share']):+.1f} points",
        )
    )
    caption = "Both engines; m, s and rad. Difference: the second less the first."
    return Section(sentences, (Table(caption, ("", *names, "difference"), tuple(rows)),))


def gait(result: dict[str, Any]) -> Section:
    """What the results of ``jaxwalk gait`` say."""
    strides, measures = result["strides"], result["measures"]
    known = {name: one["human"] for name, one in measures.items() if one.get("human")}
    ranged = {name: one for name, one in known.items() if one["low"] is not None}
    within = [name for name, one in ranged.items() if one["low"] <= measures[name]["mean"] <= one["high"]]
    sentences = (
        f"{strides['left']} left and {strides['right']} right strides of {result['walkers']} walkers, of "
        f"whom {result['fell']} fell. Of {len(ranged)} measures whose range in people is known, "
        f"{len(within)} lie within it.",
    )
    marks = {source: f"[{place}]" for place, source in enumerate(result["sources"], 1)}

    def people(name: str) -> tuple[str, str]:
        one = known.get(name)
        if one is None:
            return NOTHING, NOTHING
        span = "" if one["low"] is None else f" ({one['low']:.3g} to {one['high']:.3g})"
        inside = NOTHING if one["low"] is None else "yes" if name in within else "no"
        return f"{one['mean']:.3g}{span} {marks[one['source']]}", inside

    table = Table(
        "Over all strides. People: mean, and range or one standard deviation.",
        ("measure", "mean ± SD", "people", "within"),
        tuple(
            (
                f"{name.replace('_', ' ')}{', ' if one['unit'] else ''}{one['unit']}",
                f"{one['mean']:.3g} ± {one['sd']:.2g}",
                *people(name),
            )
            for name, one in measures.items()
        ),
    )
    symmetry = Table(
        "Symmetry index, per cent: 0 where left and right are alike.",
        ("measure", "mean", "mean size"),
        tuple(
            (name.replace("_", " "), f"{one['mean']:+.1f}", f"{one['mean_size']:.1f}")
            for name, one in result["symmetry"].items()
        ),
    )
    points = tuple(f"{marks[source]} {source}: {what}" for source, what in result["sources"].items())
    return Section(sentences, (table, symmetry), points)


def bench(result: dict[str, Any]) -> Section:
    """What the results of ``jaxwalk bench`` say."""
    programs, ratios = result["programs"], result["ratios"]
    told = ", ".join(
        f"{name.partition('/')[0].replace('_', ' ')} at {ratio:.2f}" for name, ratio in ratios.items()
    )
    sentences = (
        f"Ticks per second of {result['walkers']} walkers, as a share of bare mjx.step of the same model, "
        f"batch and cores in the same run: {told}.",
        f"A checkpoint costs training {result['checkpoint']['share']:.1%} of its time.",
    )
    rows = []
    for name, one in programs.items():
        ratio = 1.0 if name == BARE else ratios.get(f"{name}/{BARE}")
        rates = (one[f"{what}_per_second"] for what in ("physics_steps", "footsteps", "updates"))
        rows.append((name.replace("_", " "), *(number(rate, ",.0f") for rate in rates), number(ratio, ".2f")))
    header = ("program", "ticks/s", "footsteps/s", "updates/s", "of bare mjx.step")
    return Section(sentences, (Table("Medians of rounds taken in turns.", header, tuple(rows)),))
