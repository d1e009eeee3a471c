"""What searches by evolution strategies share."""

from __future__ import annotations

from collections.abc import Sequence

import cmaes
import numpy as np


def tell(search: cmaes.SepCMA, asked: Sequence[np.ndarray], scores: np.ndarray) -> np.ndarray:
    """Tell ``search`` what its candidates came to, more being better, and give what it was told.

    Args:
      scores: [K] of the candidates; who has none that is finite was worse than the worst, by 1.
    """
    told = np.array(scores, np.float64)
    sound = np.isfinite(told)
    told[~sound] = np.min(told, where=sound, initial=0.0) - 1.0
    search.tell([(one, -float(score)) for one, score in zip(asked, told, strict=True)])
    return told
