"""What both nodes do alike: begin, and end with one line where the input was wrong."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any, TypeVar

import rosgraph
import rospy

from jaxwalk.common.errors import UserError
from jaxwalk.ros import parameters

T = TypeVar("T")


def begin(name: str, kind: type[T]) -> T:
    """Be the node ``name``; gives its parameters.

    Raises:
      UserError: no master, or parameters that are no good.
    """
    if not rosgraph.is_master_online():
        raise UserError(f"{name}: no ROS master at {rosgraph.get_master_uri()}: start roscore")
    rospy.init_node(name)
    return parameters.read(kind, rospy.get_param("~", {}), name)


def run(main: Callable[[], int]) -> int:
    """The exit code of ``main``; 2 where the input was wrong, and a line says how."""
    try:
        return main()
    except UserError as error:
        print(f"jaxwalk: error: {error}", file=sys.stderr, flush=True)
        return 2
    except rospy.ROSInterruptException:
        return 0


def say(name: str) -> Callable[[str], None]:
    """What says a line for the node ``name``, on standard error."""

    def one(text: Any) -> None:
        print(f"{name}: {text}", file=sys.stderr, flush=True)

    return one
