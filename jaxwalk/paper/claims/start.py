"""Starting from the height-to-stride-length ratio, beside starting anywhere."""

from __future__ import annotations

import numpy as np

from jaxwalk.paper.claim import Numbers
from jaxwalk.paper.claims import learning
from jaxwalk.paper.verdict import Check, above, mean_of, told

NAMES = ("full", "random")


def checks(numbers: Numbers) -> tuple[Check, ...]:
    full, drawn = (
        [float(np.mean(one["curve"]["survival"])) for one in numbers["runs"][name]] for name in NAMES
    )
    # Seeds of one number share their starts and pushes: their differences are what counts.
    more = mean_of([a - b for a, b in zip(full, drawn, strict=True)])
    means = f"{np.mean(full):.3f} from the ratio, {np.mean(drawn):.3f} from a random start"
    return (
        Check(f"survival, mean of the whole learning curve: {means}; difference {told(more)}", above(more)),
    )


CLAIM = learning.claim(
    NAMES,
    checks,
    name="start",
    title="The height-to-stride-length ratio is a good start",
    says="The actor's output starts at the step that the height-to-stride-length ratio gives, which "
    "shortens training.",
    where="method, initialisation",
    rule="Averaged over its whole learning curve, a training that starts at the ratio's step survives "
    "more graded pushes than the same seed from a random first action: the mean difference is above 0 "
    "with all of its 95 % interval over seeds (Student's, three seeds).",
)
