"""``jaxwalk render``."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from jaxwalk.common import files
from jaxwalk.common.errors import UserError
from jaxwalk.options import checks, shared
from jaxwalk.options.parse import Impulses, OptionalActuators, OptionalFile, OptionalModel, Policy, reader

SUFFIXES = (".mp4", ".gif", ".png", ".html")
IMPULSES = (-80.0, -40.0, 40.0, 70.0)
_SETTLED = (
    "seconds speed push push_time push_height push_duration height mass model actuators noise seed".split()
    + ["engine"]
)
_DRAWN = (
    "session seconds push push_time push_height push_duration width height_px fps".split()
)  # not of a page


@dataclass(frozen=True)
class RenderArgs:
    """Show a policy's walk: a film (mp4, gif) or a strip of poses (png), with a push if wanted; or a page
    (html) that replays an unpushed walk and several pushed ones."""

    policy: Policy
    out: Path
    """File to draw into, replaced if there; .mp4, .gif, .png or .html."""
    seconds: float = 8.0
    """How long the walk lasts, s."""
    session: OptionalFile = None
    """Instead, walk what a page of `jaxwalk play` has saved: its body, circumstances and pushes."""
    speed: shared.Speed = 1.0
    push: float = 0.0
    """Impulse of the push, N s; positive pushes forward, 0 is none."""
    push_time: float = 3.0
    """When the push begins, s."""
    push_height: shared.PushHeight = 0.0
    push_duration: shared.PushDuration = 0.1
    impulses: Impulses = IMPULSES
    """html: pushes to replay beside the unpushed walk, N s, each at 3 s; positive ones push forward."""
    height: shared.OneStature = None
    mass: shared.OneMass = None
    model: OptionalModel = None
    actuators: OptionalActuators = None
    noise: shared.Noise = 1.0
    engine: shared.Engine = "mjx"
    width: int = 960
    """Width of the picture, pixels."""
    height_px: int = 540
    """Height of the picture, pixels."""
    fps: int = 30
    """Frames per second of film."""
    seed: shared.Seed = 0

    @property
    def page(self) -> bool:
        """Whether a page is made, not a picture."""
        return self.out.suffix.lower() == ".html"

    def check(self) -> None:
        """As `Options.check`."""
        checks.policy(self.policy)
        if self.out.suffix.lower() not in SUFFIXES:
            raise UserError(f"--out {self.out}: give a file that ends in {', '.join(SUFFIXES)}")
        files.check_output("--out", self.out)
        own = _DRAWN if self.page else ["impulses"]
        if (option := self._given(own)) is not None:
            told = "films and strips" if self.page else "pages: give --out a name that ends in .html"
            raise UserError(f"{option}: is for {told}")
        if self.session is not None and (option := self._given(_SETTLED)) is not None:
            raise UserError(f"{option}: --session settles it; leave one of the two out")
        checks.replayed(self.impulses)
        checks.between("--seconds", self.seconds, 0.1, 600.0, " s")
        checks.between("--push", self.push, -1000.0, 1000.0, " N s")
        if self.push != 0:
            checks.between("--push-time", self.push_time, 0.0, self.seconds, " s, within --seconds")
        checks.between("--push-height", self.push_height, -1.0, 1.0, " m")
        checks.push_seconds("--push-duration", self.push_duration)
        checks.walker(self)
        # The models' off-screen buffer is 1920 x 1080; half the pixels of a film must be even.
        checks.between("--width", self.width, 64, 1920, " pixels")
        checks.between("--height-px", self.height_px, 64, 1080, " pixels")
        checks.between("--fps", self.fps, 1, 120, "")
        checks.seed(self.seed)

    def _given(self, names: Sequence[str]) -> str | None:
        """The first option of ``names`` that does not have its default."""
        told = (f for f in dataclasses.fields(self) if f.name in names and getattr(self, f.name) != f.default)
        return next((f"--{field.name.replace('_', '-')}" for field in told), None)


read = reader(RenderArgs, "render")
