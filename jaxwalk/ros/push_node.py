"""A push, asked for by Gazebo's service, and no more.

python3 -m jaxwalk.ros.push_node _impulse:=40 _begin:=5
"""

from __future__ import annotations

import sys

import rospy
from geometry_msgs.msg import Point, Vector3, Wrench

from jaxwalk.common.errors import UserError
from jaxwalk.ros import gazebo, node
from jaxwalk.ros.parameters import Pushed

NAME = "jaxwalk_push"
SERVICE = "/gazebo/apply_body_wrench"


def main() -> int:
    """Ask for it.

    Raises:
      UserError: nobody simulates, or who does refuses.
    """
    told = node.begin(NAME, Pushed)
    kind = gazebo.service("ApplyBodyWrench")
    try:
        rospy.wait_for_service(SERVICE, timeout=told.patience)
        wrench = Wrench(Vector3(told.impulse / told.seconds, 0.0, 0.0), Vector3())
        times = rospy.Time.from_sec(told.begin), rospy.Duration.from_sec(told.seconds)
        answer = rospy.ServiceProxy(SERVICE, kind)(told.body, "", Point(), wrench, *times)
    except (rospy.ROSException, rospy.ServiceException) as error:
        raise UserError(f"{NAME}: {SERVICE} does not answer: {error}") from None
    if not answer.success:
        raise UserError(f"{NAME}: {SERVICE}: {answer.status_message}")
    return 0


if __name__ == "__main__":
    sys.exit(node.run(main))
