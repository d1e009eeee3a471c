"""``paper.json``: what is measured of each claim, kept as soon as it is, and used again if it still holds."""

from __future__ import annotations

import datetime
import json
import os
from collections.abc import Mapping
from typing import Any

from jaxwalk.common import files
from jaxwalk.common.errors import UserError
from jaxwalk.learn.policies import provenance
from jaxwalk.learn.policies.named import Subject
from jaxwalk.paper.claim import Claim
from jaxwalk.paper.options import PaperArgs

FILE = "paper.json"
_KEPT = ("inputs", "date", "seconds", "numbers")
_SAME = ("quick", "seed")  # options that say what is measured


class Store:
    """The file of one page.

    Args:
      args: of the command. subject: whom the claims are put to.
      inputs: of each claim, what it depends on beside those.

    Attributes:
      claims: by name, what is kept: numbers by body, inputs, date, seconds.

    Raises:
      UserError: the file that is there is damaged, or of another policy, other options or another version.
    """

    def __init__(self, args: PaperArgs, subject: Subject, inputs: Mapping[str, str]) -> None:
        self.path = args.out / FILE
        self.stamp = provenance.stamp("paper", args, subject, subject.config)
        for name in ("only", "retrain", "trained"):
            self.stamp["options"].pop(name)
        self._inputs = inputs
        self.claims: dict[str, dict[str, Any]] = {}
        if os.path.lexists(self.path):
            self._take_over(provenance.read(self.path, "paper"), subject)

    def _take_over(self, found: Mapping[str, Any], subject: Subject) -> None:
        versions = found.get("versions")
        version = versions.get("jaxwalk") if isinstance(versions, Mapping) else None
        same = all(found["options"].get(name) == self.stamp["options"][name] for name in _SAME)
        if not (provenance.is_of(found, subject) and same and version == self.stamp["versions"]["jaxwalk"]):
            raise UserError(
                f"{self.path} is of another policy, other options or another version: give --out another "
                "folder, or move it away to have it measured anew"
            )
        claims = found.get("claims")
        if not isinstance(claims, Mapping):
            raise UserError(f"{self.path} holds no claims: move it away to have them measured anew")
        for name, kept in claims.items():
            if name in self._inputs and isinstance(kept, dict) and kept.get("inputs") == self._inputs[name]:
                # What the page says of it is made of the numbers anew.
                self.claims[name] = {key: kept[key] for key in _KEPT if key in kept}

    def keep(self, claim: Claim, numbers: Mapping[str, Any], seconds: float) -> None:
        """Write down what was measured.

        Raises:
          UserError: the file cannot be written.
        """
        self.claims[claim.name] = {
            "inputs": self._inputs[claim.name],
            "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
            "seconds": round(seconds, 1),
            # As a later reader finds them: what is drawn now is what would be drawn then.
            "numbers": json.loads(files.to_json(numbers)),
        }
        self.write({})

    def write(self, told: Mapping[str, Any]) -> None:
        """Write the file; ``told``: of each claim, what the page says of it."""
        order = [name for name in self._inputs if name in self.claims]
        claims = {name: {**told.get(name, {}), **self.claims[name]} for name in order}
        files.write_json(self.path, {**self.stamp, "claims": claims})
