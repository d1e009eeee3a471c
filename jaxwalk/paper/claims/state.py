"""Whether two of the four variables of the state are enough to learn from."""

from __future__ import annotations

from jaxwalk.paper.claim import Numbers
from jaxwalk.paper.claims import learning
from jaxwalk.paper.claims.learning import MORE
from jaxwalk.paper.verdict import Check, above, below, difference, percent, told

NAMES = ("full", "pair")


def checks(numbers: Numbers) -> tuple[Check, ...]:
    out = []
    for name in NAMES:
        for one in numbers["runs"][name]:
            more = difference(one["pushed"], numbers["fixed"]["pushed"])
            answer = above(more, MORE) if name == "full" else below(more, MORE)
            out.append(
                Check(
                    f"{learning.seed_words(name, one)}: {percent(one['pushed'])}, "
                    f"{told(more)} more than the step that is never adapted",
                    answer,
                )
            )
    return tuple(out)


CLAIM = learning.claim(
    NAMES,
    checks,
    name="state",
    title="Two variables are too few: [d_zmp, phi] does not converge",
    says="With the state s = [d_zmp, phi] training does not converge; with s = [v, phi, d_zmp, l] it does.",
    where="method, the choice of the state",
    rule="A training has converged if its policy survives at least five of a hundred graded pushes more "
    "than the step that is never adapted. It holds if every seed of the full state does so and none of "
    "the pair does, each with all of its 95 % interval.",
)
