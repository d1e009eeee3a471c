"""Verdicts from numbers: intervals, yes-or-no answers with a third for what a sample cannot tell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from scipy.stats import norm, t

from jaxwalk.measure.survival import pooled

Verdict = Literal["holds", "does not hold", "cannot be told"]
HOLDS: Verdict = "holds"
FAILS: Verdict = "does not hold"
OPEN: Verdict = "cannot be told"

Interval = dict[str, Any]
"""mean, low, high (95 %) and n; a share's come from `share`."""


@dataclass(frozen=True)
class Check:
    """One thing that a claim says, put to the numbers.

    Attributes:
      says: it, with the numbers.
      answer: whether it is so; None: the sample does not decide.
    """

    says: str
    answer: bool | None


def verdict(checks: Sequence[Check]) -> Verdict:
    """A claim holds if all that it says is so; one thing that is not is enough against it."""
    answers = [check.answer for check in checks]
    if any(answer is False for answer in answers):
        return FAILS
    return HOLDS if answers and all(answers) else OPEN


def mean_of(values: Sequence[float] | np.ndarray) -> Interval:
    """The mean of independent values (walkers, seeds) with Student's interval; of fewer than two, none."""
    finite = np.asarray([x for x in values if np.isfinite(x)], float)
    count = len(finite)
    if count == 0:
        return {"mean": None, "low": None, "high": None, "n": 0}
    mean = float(finite.mean())
    if count == 1:
        return {"mean": mean, "low": None, "high": None, "n": 1}
    half = float(t.ppf(0.975, count - 1) * finite.std(ddof=1) / np.sqrt(count))
    return {"mean": mean, "low": mean - half, "high": mean + half, "n": count}


def share(up: np.ndarray) -> Interval:
    """The share of true among independent outcomes, with Wilson's interval."""
    told = pooled(int(np.sum(up)), int(np.size(up)))
    return {"mean": told["share"], "low": told["low"], "high": told["high"], "n": told["trials"]}


def difference(one: Interval, other: Interval) -> Interval:
    """``one`` less ``other``, two independent shares (Newcombe 1998, method 10)."""
    mean = one["mean"] - other["mean"]
    below = np.hypot(one["mean"] - one["low"], other["high"] - other["mean"])
    over = np.hypot(one["high"] - one["mean"], other["mean"] - other["low"])
    return {"mean": mean, "low": mean - float(below), "high": mean + float(over), "n": one["n"] + other["n"]}


def slope(x: Sequence[float] | np.ndarray, y: Sequence[float] | np.ndarray) -> Interval:
    """The line's slope through independent points, with its normal interval; none without two places."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    keep = np.isfinite(x) & np.isfinite(y)
    x, y = x[keep], y[keep]
    spread = float(np.sum((x - x.mean()) ** 2)) if len(x) > 2 else 0.0
    if spread == 0.0:
        return {"mean": None, "low": None, "high": None, "n": len(x)}
    mean = float(np.sum((x - x.mean()) * (y - y.mean())) / spread)
    residual = y - y.mean() - mean * (x - x.mean())
    half = float(norm.ppf(0.975) * np.sqrt(np.sum(residual**2) / (len(x) - 2) / spread))
    return {"mean": mean, "low": mean - half, "high": mean + half, "n": len(x)}


def above(interval: Interval, bar: float = 0.0) -> bool | None:
    """Whether all of the interval is above ``bar``; False if all is below, None between."""
    if interval["low"] is None:
        return None
    return True if interval["low"] > bar else False if interval["high"] < bar else None


def below(interval: Interval, bar: float = 0.0) -> bool | None:
    """Whether all of the interval is below ``bar``; False if all is above, None between."""
    answer = above(interval, bar)
    return None if answer is None else not answer


def within(interval: Interval, low: float, high: float) -> bool | None:
    """Whether all of the interval lies between ``low`` and ``high``; False if none of it does, None else."""
    if interval["low"] is None:
        return None
    if low <= interval["low"] and interval["high"] <= high:
        return True
    return False if interval["high"] < low or interval["low"] > high else None


def told(interval: Interval, form: str = ".3f") -> str:
    """As a page says it: mean (low to high)."""
    if interval["mean"] is None:
        return "no number"
    if interval["low"] is None:
        return f"{interval['mean']:{form}} (one value)"
    return f"{interval['mean']:{form}} ({interval['low']:{form}} to {interval['high']:{form}})"


def percent(interval: Interval) -> str:
    """A share as a page says it."""
    if interval["mean"] is None:
        return "no number"
    low, high = 100 * interval["low"], 100 * interval["high"]
    return f"{100 * interval['mean']:.1f} % ({low:.1f} to {high:.1f}) of {interval['n']}"
