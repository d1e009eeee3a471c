"""jaxwalk: learned stepping for powered exoskeletons, many walkers at once in MJX.

    import jaxwalk as jw

    run = jw.train(jw.preset("quick"), "runs/first", seed=1)
    print(jw.evaluate(jw.load_policy(run))["threshold"])

Importing the package imports nothing else: each name is fetched when it is first asked for.
"""

import sys
import threading
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from jaxwalk.api import (
        Config,
        Controller,
        FootstepEnv,
        PushTest,
        Subject,
        UserError,
        evaluate,
        export_policy,
        load_policy,
        preset,
        push_map,
        resume,
        train,
    )

__version__ = "0.1.0"
_LOCK = threading.RLock()

__all__ = [
    "Config",
    "Controller",
    "FootstepEnv",
    "PushTest",
    "Subject",
    "UserError",
    "__version__",
    "evaluate",
    "export_policy",
    "load_policy",
    "preset",
    "push_map",
    "resume",
    "train",
]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module 'jaxwalk' has no attribute {name!r}")
    with _LOCK:  # or two threads would set JAX up at once
        if "jaxwalk.api" not in sys.modules:
            import_module("jaxwalk.common.runtime").setup(begun=True)  # before what computes
        return getattr(import_module("jaxwalk.api"), name)


def __dir__() -> list[str]:
    return __all__
