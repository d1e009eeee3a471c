"""What the claims about training share: their table, their figure, and what is said without files."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from matplotlib.figure import Figure

from jaxwalk.config import BodyModel
from jaxwalk.paper import pictures
from jaxwalk.paper.claim import Claim, Numbers
from jaxwalk.paper.lab import examined
from jaxwalk.paper.trainings import TRAININGS
from jaxwalk.paper.verdict import Check

MORE = 0.05  # share of pushes; a smaller difference is none


def claim(trainings: tuple[str, ...], checks: Callable[[Numbers], tuple[Check, ...]], **words: str) -> Claim:
    """One about ``trainings``, in the plane.

    Args:
      checks: as a claim's, of numbers of which none is missing.
      words: the claim's others.
    """
    return Claim(
        **words,
        bodies=("planar",),
        quick=("planar",),
        measure=lambda lab, model: examined(lab, trainings),
        checks=lambda numbers: absent(numbers) or checks(numbers),
        table=table,
        draw=draw,
        trainings=trainings,
    )


def absent(numbers: Numbers) -> tuple[Check, ...]:
    """What is said in place of an answer where trainings are missing; nothing where all are there."""
    files = numbers["missing"]
    if not files:
        return ()
    more = f" and {len(files) - 1} more" if len(files) > 1 else ""
    return (Check(f"not trained yet: {files[0]}{more} missing; jaxwalk paper --retrain trains them", None),)


def table(numbers: Numbers) -> list[dict[str, object]]:
    rows: list[dict[str, Any]] = []
    for name, seeds in numbers.get("runs", {}).items():
        for one in seeds:
            told = one["curve"]
            each = zip(told["footsteps"], told["survival"], told["score"], strict=True)
            rows += [
                {"training": name, "seed": one["seed"], "footsteps": f, "survival": u, "score": s}
                for f, u, s in each
            ]
            kept = {
                "training": name,
                "seed": one["seed"],
                "footsteps": "kept",
                "survival": one["pushed"]["mean"],
            }
            rows.append({**kept, "score": ""})
    return rows


def draw(numbers: Mapping[BodyModel, Numbers]) -> Figure | None:
    """Curves and exams; nothing where trainings are missing."""
    one = numbers["planar"]
    if one["missing"]:
        return None
    figure, axes = pictures.panels(1, 2, width=5.0)
    pictures.curves(axes[0, 0], one["runs"], one["fixed"])
    pictures.exams(axes[0, 1], one["runs"], one["fixed"])
    return figure


def seed_words(name: str, one: Mapping[str, Any]) -> str:
    return f"{TRAININGS[name].words}, seed {one['seed']}"
