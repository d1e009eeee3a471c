"""What the keys of the viewer do."""

from __future__ import annotations

from dataclasses import dataclass, replace

RIGHT, LEFT, DOWN, UP, SPACE, RESTART = 262, 263, 264, 265, 32, ord("R")  # GLFW's codes
STEP, LEAST, MOST = 10.0, 10.0, 200.0  # of the impulse, N s

HELP = (
    ("left, right", "push backward, forward"),
    ("up, down", "change the impulse"),
    ("R", "start anew"),
    ("space", "pause"),
)


@dataclass(frozen=True)
class Wishes:
    """What whoever watches has asked for by key.

    Attributes:
      impulse: of the next push, N s, without its direction.
      paused: time stands still.
      push: asked for and not made yet, N s, forward positive; 0: none.
      restart: asked for and not made yet.
    """

    impulse: float = 40.0
    paused: bool = False
    push: float = 0.0
    restart: bool = False


def pressed(wishes: Wishes, key: int) -> Wishes:
    """The wishes after one more key; any other key changes nothing."""
    if key in (LEFT, RIGHT):
        return replace(wishes, push=wishes.impulse if key == RIGHT else -wishes.impulse)
    if key in (UP, DOWN):
        changed = wishes.impulse + (STEP if key == UP else -STEP)
        return replace(wishes, impulse=min(MOST, max(LEAST, changed)))
    if key == SPACE:
        return replace(wishes, paused=not wishes.paused)
    if key == RESTART:
        return replace(wishes, restart=True, paused=False)
    return wishes


def granted(wishes: Wishes) -> Wishes:
    """The wishes once they have been met."""
    return replace(wishes, push=0.0, restart=False)
