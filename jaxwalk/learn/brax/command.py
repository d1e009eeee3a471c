"""``jaxwalk train-baseline``, on the default configuration."""

from __future__ import annotations

from typing import TYPE_CHECKING

from jaxwalk.config import Config
from jaxwalk.learn.brax import baselines

if TYPE_CHECKING:
    from jaxwalk.learn.brax.options import PPOArgs, SACArgs


def main(args: PPOArgs | SACArgs, typed: str) -> None:
    """Run ``jaxwalk train-baseline``.

    Args:
      typed: it, as it was given, which the run's record holds.
    """
    baselines.train(Config(), args, typed)
