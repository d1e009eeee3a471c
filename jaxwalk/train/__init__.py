"""Training: the device loop, the evaluations within it, the run around both, of one seed or of many."""

from jaxwalk.train.many import resume_many, run_many
from jaxwalk.train.run import resume, run

__all__ = ["resume", "resume_many", "run", "run_many"]
