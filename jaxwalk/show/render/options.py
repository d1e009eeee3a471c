"""``jaxwalk render``."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from jaxwalk.common import files
from jaxwalk.common.errors import UserError
from jaxwalk.options import checks
from jaxwalk.options.parse import Impulses, OptionalFloat, OptionalModel, Policy, checked

SUFFIXES = (".mp4", ".gif", ".png", ".html")
IMPULSES = (-80.0, -40.0, 40.0, 70.0)
_DRAWN = "seconds push push_time push_height push_duration width height_px fps".split()  # not of a page


@dataclass(frozen=True)
class RenderArgs:
    """Show a policy's walk: a film (mp4, gif) or a strip of poses (png), with a push if wanted; or a page
    (html) that replays an unpushed walk and several pushed ones."""

    policy: Policy
    out: Path
    """File to draw into, replaced if there; .mp4, .gif, .png or .html."""
    seconds: float = 8.0
    """How long the walk lasts, s."""
    speed: float = 1.0
    """Forward speed that is asked for, m/s."""
    push: float = 0.0
    """Impulse of the push, N s; positive pushes forward, 0 is none."""
    push_time: float = 3.0
    """When the push begins, s."""
    push_height: float = 0.0
    """Where the push lands, m above the torso's centre."""
    push_duration: float = 0.1
    """How long the push lasts, s."""
    impulses: Impulses = IMPULSES
    """html: pushes to replay beside the unpushed walk, N s, each at 3 s; positive ones push forward."""
    height: OptionalFloat = None
    """Stature, m. Default: that of the policy's configuration."""
    mass: OptionalFloat = None
    """Mass, kg. Default: that of the policy's configuration."""
    model: OptionalModel = None
    noise: float = 1.0
    """Scale of the sensors' noise and bias: 1 realistic, 0 none."""
    width: int = 960
    """Width of the picture, pixels."""
    height_px: int = 540
    """Height of the picture, pixels."""
    fps: int = 30
    """Frames per second of film."""
    seed: int = 0
    """Seed of everything that is drawn at random."""

    @property
    def page(self) -> bool:
        """Whether a page is made, not a picture."""
        return self.out.suffix.lower() == ".html"

    def check(self) -> None:
        """See that the options can be meant.

        Raises:
          UserError: an option out of its range.
        """
        checks.policy(self.policy)
        if self.out.suffix.lower() not in SUFFIXES:
            raise UserError(f"--out {self.out}: give a file that ends in {', '.join(SUFFIXES)}")
        files.check_output("--out", self.out)
        own = _DRAWN if self.page else ["impulses"]
        for field in dataclasses.fields(self):
            if field.name in own and getattr(self, field.name) != field.default:
                told = "films and strips" if self.page else "pages: give --out a name that ends in .html"
                raise UserError(f"--{field.name.replace('_', '-')}: is for {told}")
        checks.replayed(self.impulses)
        checks.between("--seconds", self.seconds, 0.1, 600.0, " s")
        checks.between("--speed", self.speed, 0.1, 3.0, " m/s")
        checks.between("--push", self.push, -1000.0, 1000.0, " N s")
        if self.push != 0:
            checks.between("--push-time", self.push_time, 0.0, self.seconds, " s, within --seconds")
        checks.between("--push-height", self.push_height, -1.0, 1.0, " m")
        checks.push_seconds("--push-duration", self.push_duration)
        checks.person(self.height, self.mass)
        checks.between("--noise", self.noise, 0.0, 100.0, "")
        # The models' off-screen buffer is 1920 x 1080; half the pixels of a film must be even.
        checks.between("--width", self.width, 64, 1920, " pixels")
        checks.between("--height-px", self.height_px, 64, 1080, " pixels")
        checks.between("--fps", self.fps, 1, 120, "")
        checks.seed(self.seed)


def read(argv: Sequence[str]) -> RenderArgs:
    """The options, checked.

    Raises:
      UserError: one of them is wrong.
    """
    return checked(RenderArgs, argv, "render")
