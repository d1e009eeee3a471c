"""What ``jaxwalk export --format html``, as pages were once asked for, comes to: render's."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from jaxwalk.common import files
from jaxwalk.learn.policies import named
from jaxwalk.options import lines
from jaxwalk.show.render import command
from jaxwalk.show.render.options import RenderArgs

if TYPE_CHECKING:
    from jaxwalk.export.options import PageArgs


def write(args: PageArgs) -> None:
    """The page in ``--out``, and the line that is to be typed for it.

    Raises:
      UserError: as for ``jaxwalk render``.
    """
    config = named.load(args.policy, model=args.model, actuators=args.actuators).config
    asked = RenderArgs(
        args.policy,
        args.out / "replay.html",
        speed=config.gait.speed_desired,
        noise=config.sensors.noise,
        impulses=RenderArgs.impulses if args.impulses is None else args.impulses,
        model=args.model,
        actuators=args.actuators,
        seed=args.seed,
    )
    files.make_folder("--out", args.out)
    asked.check()
    print(f"jaxwalk: a page is made by {lines.line('render', asked)}", file=sys.stderr)
    command.main(asked)
