"""Where a page's policy comes from, as its foot says."""

from __future__ import annotations

from jaxwalk.learn.policies import policy
from jaxwalk.learn.policies.named import Subject


def facts(subject: Subject, origin: policy.Metadata | None) -> list[tuple[str, str]]:
    """(name, value) of ``subject``; ``origin`` is None for a rule."""
    told = [("Policy", f"{subject.name}, parameters {subject.digest[:12]}")]
    if origin is None:
        return [*told, ("Trained", "no: a rule")]
    trained = f"{origin.footsteps:,} footsteps, seed {origin.seed}, jaxwalk {origin.jaxwalk_version}"
    return [*told, ("Trained", trained), ("Trained by", origin.command)]
