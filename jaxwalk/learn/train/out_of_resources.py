"""What the machine has too little of for a training, as one line."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path

import jax

from jaxwalk.common import runtime
from jaxwalk.common.errors import UserError
from jaxwalk.config import Config


def check_memory(config: Config, taken: int) -> None:
    """See that the memory of a CPU, which ends the process where it is short, holds a training.

    Args:
      taken: bytes of its state, of which a second one is made on the way.

    Raises:
      UserError: it does not.
    """
    if jax.default_backend() == "cpu" and 2 * taken > runtime.memory_left():
        raise UserError(_too_much(config))


@contextlib.contextmanager
def explained(config: Config, path: Path) -> Iterator[None]:
    """Within it, a full disk or memory becomes one line for the user.

    Raises:
      UserError: the disk of the run in ``path``, or the memory, is full.
    """
    try:
        yield
    except BrokenPipeError:  # nobody reads what is told any more
        raise
    except OSError as error:
        raise UserError(
            f"cannot write into {path}: {error.strerror or error}; make room there, then go on with "
            f"jaxwalk train --resume {path}"
        ) from error
    except (MemoryError, jax.errors.JaxRuntimeError) as error:
        if isinstance(error, jax.errors.JaxRuntimeError) and "RESOURCE_EXHAUSTED" not in str(error):
            raise
        raise UserError(_too_much(config)) from error


def _too_much(config: Config) -> str:
    return (
        f"out of memory: begin a run with less than --train.walkers {config.train.walkers} or "
        f"--ddpg.replay-capacity {config.ddpg.replay_capacity}"
    )
