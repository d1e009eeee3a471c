"""Packs and statures that the policy was not trained for."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import jax
import jax.numpy as jnp
import numpy as np
from matplotlib.figure import Figure

from jaxwalk.config import BodyModel
from jaxwalk.model.burdens import BACKPACK, FRONT_PACK, Burden
from jaxwalk.paper import pictures
from jaxwalk.paper.claim import Claim, Numbers
from jaxwalk.paper.lab import Lab, speeds_of
from jaxwalk.paper.verdict import Check, above, mean_of, percent, share, told
from jaxwalk.task import scenarios
from jaxwalk.task.trials import survived

MOST = 0.9
HEIGHTS = {False: (1.4, 1.55, 1.7, 2.0, 2.15, 2.3), True: (1.4, 2.3)}  # m
EACH = {False: 40, True: 38}  # walkers; fewer than 36 cannot show nine in ten
SECONDS = {False: 15.0, True: 8.0}


def measure(lab: Lab, model: BodyModel) -> Numbers:
    subject, each = lab.subject(model), EACH[lab.quick]
    body, friction = subject.config.body, subject.config.physics.friction
    few = lab.quick or model == "walls"
    cases = [
        ("nothing to carry", body.height, Burden(0.0, *BACKPACK, 0.0, friction)),
        ("10 kg backpack", body.height, Burden(10.0, *BACKPACK, 0.0, friction)),
        ("25 kg front pack", body.height, Burden(25.0, *FRONT_PACK, 0.0, friction)),
        *((f"{height:g} m tall", height, Burden(0.0, *BACKPACK, 0.0, friction)) for height in HEIGHTS[few]),
    ]
    batches = []
    for _, height, burden in cases:
        # People of one shape weigh with the cube of their stature.
        mass = body.mass * (height / body.height) ** 3
        config = dataclasses.replace(subject.config, body=dataclasses.replace(body, height=height, mass=mass))
        person = dataclasses.replace(subject, config=config)
        none = np.zeros(each)
        batches.append(lab.scenarios(person, none, none, scenarios.CALM, burden=burden))
    together = jax.tree.map(lambda *x: jnp.concatenate(x), *batches)
    trials = lab.trial(subject, together, SECONDS[lab.quick], what="loads")
    up = survived(trials)
    rows = []
    for place, (name, height, burden) in enumerate(cases):
        here = slice(place * each, (place + 1) * each)
        row = {"case": name, "height": height, "pack": burden.mass}
        rows.append({**row, "up": share(up[here]), "speed": mean_of(speeds_of(trials, here))})
    return {"seconds": SECONDS[lab.quick], "rows": rows}


def checks(numbers: Numbers) -> tuple[Check, ...]:
    def words(row: Numbers) -> str:
        speed = f", at {told(row['speed'])} m/s" if row["speed"]["n"] else ""
        return f"{row['case']}: up {percent(row['up'])}{speed}"

    return tuple(Check(words(row), above(row["up"], MOST)) for row in numbers["rows"])


def table(numbers: Numbers) -> list[dict[str, object]]:
    return [
        {
            "case": row["case"], "height": row["height"], "pack_kg": row["pack"],
            **{f"{what}_{k}": v for what in ("up", "speed") for k, v in row[what].items()},
        }
        for row in numbers["rows"]
    ]  # fmt: skip


def draw(numbers: Mapping[BodyModel, Numbers]) -> Figure:
    figure, axes = pictures.panels(2, len(numbers), width=4.8, sharex="col", sharey="row")
    for column, (body, one) in enumerate(numbers.items()):
        colour = pictures.COLOURS[body]
        for place, row in enumerate(one["rows"]):
            pictures.bar(axes[0, column], place, row["up"], colour)
            pictures.bar(axes[1, column], place, row["speed"], colour)
        names = [row["case"] for row in one["rows"]]
        axes[1, column].set_xticks(range(len(names)), names, rotation=35, ha="right", fontsize=8)
        pictures.shares(axes[0, column])
    axes[0, 0].set_ylabel("still up, share")
    axes[1, 0].set_ylabel("speed, m/s")
    pictures.bodies(axes, numbers)
    return figure


CLAIM = Claim(
    name="loads",
    title="Carries packs and suits other statures, unchanged",
    says="It “also maintains stable walking with a 10 kg backpack or a 25 kg front pack. The controller "
    "was trained on a 1.8 m tall model, but also stabilizes models 1.4–2.3 m tall with no changes.”",
    where="abstract (journal)",
    rule=f"With the policy frozen, in each case more than {100 * MOST:g} % of unpushed walkers stay up, "
    "with all of the 95 % interval.",
    bodies=("planar", "walls"),
    quick=("planar", "walls"),
    measure=measure,
    checks=checks,
    table=table,
    draw=draw,
)
