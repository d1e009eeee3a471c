"""Training: the device loop, the evaluations within it, the run around both."""

from jaxwalk.train.run import run

__all__ = ["run"]
