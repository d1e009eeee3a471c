# MuJoCo's names come from compiled modules that say nothing of their types.
from typing import Any

def __getattr__(name: str) -> Any: ...
