"""Pushes that begin in toe-off beside those that begin in forward swing."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from jaxwalk.config import BodyModel
from jaxwalk.paper import pictures
from jaxwalk.paper.claim import Claim, Numbers
from jaxwalk.paper.lab import Lab
from jaxwalk.paper.trace import landings
from jaxwalk.paper.verdict import Check, above, difference, percent, share, told

IMPULSES = (60.0, 75.0, 90.0, 105.0, -60.0, -80.0, -100.0, -120.0)  # N s; where some fall
EACH = 4  # moments within each part of the step
PARTS = ("toe-off", "swing")


def _parts(lab: Lab, model: BodyModel) -> dict[str, tuple[float, float]]:
    """Where toe-off and forward (early) swing lie, as shares of the unpushed step."""
    trace, dt = lab.trace(model), lab.timestep(model)
    seconds, toe_off, swung = [], [], []
    for walker in range(len(trace.velocity)):
        ends = landings(trace, walker)
        for a, b in itertools.pairwise(ends):
            seconds.append((b - a) * dt)
            toe_off.append(float(trace.toe_off[walker, b - 1]))
            swung.append(toe_off[-1] + float(trace.duration[walker, b - 1]))
    if not seconds:
        return {"toe-off": (0.0, 0.15), "swing": (0.15, 0.5)}  # nobody walked: the nominal step's
    whole = np.mean(seconds)
    begin, end = float(np.mean(toe_off) / whole), float(min(np.mean(swung) / whole, 1.0))
    return {"toe-off": (0.0, begin), "swing": (begin, end)}


def measure(lab: Lab, model: BodyModel) -> Numbers:
    subject, parts = lab.subject(model), _parts(lab, model)
    replicas = (1 if lab.quick else 6) if model == "planar" else (1 if lab.quick else 2)
    moments = {
        p: [low + (high - low) * (k + 0.5) / EACH for k in range(EACH)] for p, (low, high) in parts.items()
    }
    grid = [(i, p, m) for i in IMPULSES for p in PARTS for m in moments[p]] * replicas
    impulse, phase = np.array([g[0] for g in grid]), np.array([g[2] for g in grid])
    part = np.array([g[1] for g in grid])
    up = lab.pushed(subject, lab.scenarios(subject, impulse, phase), None)["up"]
    ways = {"both ways": impulse != 0, "forward": impulse > 0, "backward": impulse < 0}
    return {
        "parts": {p: list(where) for p, where in parts.items()},
        "ways": {w: {p: share(up[mask & (part == p)]) for p in PARTS} for w, mask in ways.items()},
        "rows": [
            {
                "impulse": i,
                "part": p,
                "phase": round(m, 4),
                **share(up[(impulse == i) & (part == p) & (phase == m)]),
            }
            for i in IMPULSES
            for p in PARTS
            for m in moments[p]
        ],
    }


def checks(numbers: Numbers) -> tuple[Check, ...]:
    def words(way: str) -> tuple[str, dict]:
        told_by = numbers["ways"][way]
        apart = difference(told_by["toe-off"], told_by["swing"])
        message = (
            f"{way}: in toe-off {percent(told_by['toe-off'])}, in forward swing {percent(told_by['swing'])}"
        )
        return f"{message}; difference {told(apart, '.3f')}", apart

    both, apart = words("both ways")
    ways = "; ".join(words(way)[0] for way in ("forward", "backward"))
    return (Check(f"{both}. By direction, {ways}", above(apart)),)


def table(numbers: Numbers) -> list[dict[str, object]]:
    return list(numbers["rows"])


def draw(numbers: Mapping[BodyModel, Numbers]) -> Figure:
    figure, axes = pictures.panels(1, len(numbers), width=4.8, sharey=True)
    for column, one in enumerate(numbers.values()):
        panel = axes[0, column]
        for place, way in enumerate(one["ways"]):
            for offset, part, colour in ((-0.2, "toe-off", pictures.BLUE), (0.2, "swing", pictures.ORANGE)):
                pictures.bar(panel, place + offset, one["ways"][way][part], colour, 0.36)
        panel.bar(0, 0, color=pictures.BLUE, label="begun in toe-off")
        panel.bar(0, 0, color=pictures.ORANGE, label="begun in forward swing")
        (_, toe_off), (_, swung) = one["parts"]["toe-off"], one["parts"]["swing"]
        panel.set_xlabel(
            f"toe-off: to {100 * toe_off:.0f} % of the step; forward swing: to {100 * swung:.0f} %"
        )
        panel.set_xticks(range(len(one["ways"])), list(one["ways"]))
        pictures.shares(panel)
    axes[0, 0].set_ylabel("pushes survived, share")
    pictures.legend(figure, axes[0, 0])
    pictures.bodies(axes, numbers)
    return figure


CLAIM = Claim(
    name="phases",
    title="Toe-off tolerates pushes better than forward swing",
    says="Pushes during toe-off are tolerated better than pushes during forward swing.",
    where="results",
    rule="Of the same pushes, 60 to 105 N s forward and 60 to 120 backward, a greater share is survived "
    "when they begin in toe-off than when they begin in early (forward) swing: the difference, both ways "
    "together, is above 0 with all of its 95 % interval.",
    bodies=("planar", "walls"),
    quick=("planar",),
    measure=measure,
    checks=checks,
    table=table,
    draw=draw,
)
