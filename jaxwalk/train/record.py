"""What a run knows beside its TrainState: plain values that a checkpoint's notes carry."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from jaxwalk.train.assess import Assessment


@dataclass
class Record:
    """Kept up to date by the run.

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
    last: Assessment | None = None
    found: dict[int, Assessment] = field(default_factory=dict)
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
        """What ``to_notes`` made notes of."""
        found = {int(footsteps): Assessment(**one) for footsteps, one in notes["found"].items()}
        last = notes["last"] and Assessment(**notes["last"])
        return cls(**{**notes, "found": found, "last": last, "totals": dict(notes["totals"])})
