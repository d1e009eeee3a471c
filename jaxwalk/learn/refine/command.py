"""``jaxwalk refine``: a search, and which of the two policies is kept."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table

from jaxwalk import __version__
from jaxwalk.common.interrupt import Stop
from jaxwalk.learn.policies import named, policy
from jaxwalk.learn.refine import search

if TYPE_CHECKING:
    from jaxwalk.learn.refine.options import RefineArgs


def main(args: RefineArgs, typed: str) -> None:
    """Run ``jaxwalk refine``; Ctrl-C ends the search after the generation under way.

    Args:
      typed: it, as it was given, which the policy's record holds.

    Raises:
      UserError: a rule that nobody trained, or a file that cannot be written.
    """
    trained, config = named.trained(args.policy)
    with Stop("generation") as stop:

        def tell(generation: int, score: float) -> bool:
            print(f"generation {generation} of {args.generations}: mean score {score:.3f}", flush=True)
            return stop.wanted

        found = search.run(config, trained, args.seed, args.generations, args.candidates, args.sigma, tell)
    meta = trained.metadata
    told = dataclasses.replace(
        meta, command=f"{meta.command}; {typed}", score=None, jaxwalk_version=__version__
    )
    kept = dataclasses.replace(found.policy, metadata=told) if found.better else trained
    policy.save(kept, args.out)
    heads = "", "score", "survival", "worst phases", "calm", "speed, m/s"
    table = Table(*heads, title="pushes not seen before")
    for name, marks in (("given", found.before), ("found", found.after)):
        shares = (f"{x:.1%}" for x in (marks.survival, marks.worst, marks.calm))
        table.add_row(name, f"{marks.score:.3f}", *shares, f"{marks.speed:.3f}")
    Console(markup=False).print(table)
    print(f"{args.out}: the one that was {'found' if found.better else 'given'}")
