"""Training: the device loop, the evaluations within it, the run around both."""

from jaxwalk.train.run import resume, run

__all__ = ["resume", "run"]
