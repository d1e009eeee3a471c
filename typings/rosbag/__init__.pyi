# Of Debian's ROS, which is not among Python's packages.
from typing import Any

def __getattr__(name: str) -> Any: ...
