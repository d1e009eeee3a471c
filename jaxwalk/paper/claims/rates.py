"""The learning rates as printed, beside ones that work."""

from __future__ import annotations

from jaxwalk.paper.claim import Numbers
from jaxwalk.paper.claims import learning
from jaxwalk.paper.claims.learning import MORE
from jaxwalk.paper.verdict import Check, above, difference, percent, told

NAMES = ("full", "printed")


def checks(numbers: Numbers) -> tuple[Check, ...]:
    out = []
    for full, printed in zip(*(numbers["runs"][name] for name in NAMES), strict=True):
        more = difference(printed["pushed"], full["pushed"])
        out.append(
            Check(
                f"seed {full['seed']}: as printed {percent(printed['pushed'])}, working "
                f"{percent(full['pushed'])}; difference {told(more)}",
                above(more, -MORE),
            )
        )
    return tuple(out)


CLAIM = learning.claim(
    NAMES,
    checks,
    name="rates",
    title="Learning rates of 1e-8 and 2e-8",
    says="Actor and critic learn with rates of 1e-8 and 2e-8, as printed.",
    where="table of hyper-parameters",
    rule="With the printed rates (all else equal to the trainings of the full state, whose rates are "
    "3e-4) every seed survives at most five of a hundred graded pushes fewer than the same seed with the "
    "working rates, with all of the 95 % interval. It does not hold if one seed survives clearly fewer.",
)
