"""What a run knows beside its TrainState: plain values that a checkpoint's notes carry."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from jaxwalk.learn.train.evaluation import Marks


@dataclass
class Record:
    """What a run has come to so far; it keeps this up to date.

    Attributes:
      seconds: trained before this process, s. compile_seconds: until the first report, s.
      evaluated: footsteps at the latest evaluation; -1: none yet.
      last: what it found.
      found: evaluations of finite score by their footsteps.
      best: footsteps at the best of them.
      totals: of events that reports count, those of footsteps gone back over included.
      divergences: footsteps at which training went back, and to which.
    """

    seconds: float = 0.0
    compile_seconds: float = 0.0
    evaluated: int = -1
    last: Marks | None = None
    found: dict[int, Marks] = field(default_factory=dict)
    best: int = 0
    totals: dict[str, float] = field(default_factory=lambda: {"falls": 0.0, "broken": 0.0})
    divergences: list[dict[str, int]] = field(default_factory=list)

    def to_notes(self) -> dict[str, Any]:
        """JSON values; they share nothing with the record."""
        notes = asdict(self)
        notes["found"] = {str(footsteps): found for footsteps, found in notes["found"].items()}
        return notes

    @classmethod
    def from_notes(cls, notes: Mapping[str, Any]) -> Record:
        """What ``to_notes`` made notes of.

        Raises:
          KeyError, TypeError, ValueError: it did not make these.
        """
        record = cls(
            seconds=_number(notes["seconds"]),
            compile_seconds=_number(notes["compile_seconds"]),
            evaluated=_whole(notes["evaluated"]),
            last=None if notes["last"] is None else _marks(notes["last"]),
            found={int(footsteps): _marks(one) for footsteps, one in notes["found"].items()},
            best=_whole(notes["best"]),
            totals={name: _number(notes["totals"][name]) for name in ("falls", "broken")},
            divergences=[{name: _whole(x) for name, x in one.items()} for one in notes["divergences"]],
        )
        if record.found and record.best not in record.found:
            raise ValueError("the best evaluation is none of those found")
        return record


@dataclass
class Past:
    """All that a checkpoint's notes tell of a run.

    Attributes:
      rows: of metrics so far.
      record: what it knows.
      finalists: (footsteps, score) of the policies that go to the finals.
    """

    rows: int
    record: Record
    finalists: Sequence[tuple[int, float]]

    def to_notes(self) -> dict[str, Any]:
        """JSON values; they share nothing with the record."""
        finalists = [list(one) for one in self.finalists]
        return {"rows": self.rows, "record": self.record.to_notes(), "finalists": finalists}

    @classmethod
    def from_notes(cls, notes: Mapping[str, Any]) -> Past:
        """What ``to_notes`` made notes of.

        Raises:
          KeyError, TypeError, ValueError: it did not make these.
        """
        finalists = [(_whole(footsteps), _number(score)) for footsteps, score in notes["finalists"]]
        return cls(_whole(notes["rows"]), Record.from_notes(notes["record"]), finalists)


def _marks(notes: Any) -> Marks:
    return Marks(**{name: _number(x) for name, x in notes.items()})


def _number(value: Any) -> float:
    if type(value) not in (int, float):
        raise TypeError("not a number")
    return value


def _whole(value: Any) -> int:
    if type(value) is not int or value < -1:
        raise TypeError("not a whole number")
    return value
