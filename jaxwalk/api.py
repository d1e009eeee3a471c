"""What a program calls; ``import jaxwalk as jw`` offers these names. The commands call the same functions.

They may be called from a thread, from a notebook, and from a process that has computed with JAX before, whose
number of CPU devices then stays what it was.
"""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import Any

from jaxwalk.common import runtime

runtime.setup(begun=True)

from jaxwalk.common.errors import UserError  # noqa: E402
from jaxwalk.config import BodyModel, Config, Engine  # noqa: E402
