"""``jaxwalk demo``: the shipped policy on a page, to be pushed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from jaxwalk.learn.policies import named
from jaxwalk.show.play import command as play

if TYPE_CHECKING:
    from jaxwalk.demo.options import DemoArgs


def main(args: DemoArgs) -> None:
    """Run ``jaxwalk demo``.

    Raises:
      UserError: the file cannot be written.
    """
    play.write(args.out, named.load(named.SHIPPED), "jaxwalk demo", args.open)
