"""Gazebo's two services, which Debian does not package: made from Gazebo's own definitions, with their md5.

A client that was built against gazebo_msgs calls them as it would Gazebo's.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import genmsg
import genpy.dynamic
from genmsg import gentools, msg_loader

_EFFORT = """string joint_name
float64 effort
time start_time
duration duration
"""
_WRENCH = """string body_name
string reference_frame
geometry_msgs/Point reference_point
geometry_msgs/Wrench wrench
time start_time
duration duration
"""
_ANSWER = """bool success
string status_message
"""
_VECTOR = "float64 x\nfloat64 y\nfloat64 z\n"
_PARTS = {
    "geometry_msgs/Point": _VECTOR,
    "geometry_msgs/Vector3": _VECTOR,
    "geometry_msgs/Wrench": "Vector3 force\nVector3 torque\n",
}
_ASKED = {"ApplyJointEffort": _EFFORT, "ApplyBodyWrench": _WRENCH}


@cache
def service(name: str) -> Any:
    """The class of ``gazebo_msgs/name``, as rospy takes one.

    Args:
      name: ApplyJointEffort or ApplyBodyWrench.
    """
    full, asked = f"gazebo_msgs/{name}", _ASKED[name]
    context = msg_loader.MsgContext.create_default()
    for kind, text in _PARTS.items():
        context.register(kind, msg_loader.load_msg_from_string(context, text, kind))
    spec = msg_loader.load_srv_from_string(context, f"{asked}---\n{_ANSWER}", full)
    for part in (spec.request, spec.response):
        genmsg.msg_loader.load_depends(context, part, {})
    request = genpy.dynamic.generate_dynamic(f"{full}Request", asked + _told())[f"{full}Request"]
    response = genpy.dynamic.generate_dynamic(f"{full}Response", _ANSWER)[f"{full}Response"]
    members = {
        "_type": full,
        "_md5sum": gentools.compute_md5(context, spec),
        "_request_class": request,
        "_response_class": response,
    }
    return type(name, (), members)


def _told() -> str:
    """The definitions of parts, as a message's full text has them."""
    line = "=" * 80
    return "".join(f"{line}\nMSG: {kind}\n{text}" for kind, text in _PARTS.items())
