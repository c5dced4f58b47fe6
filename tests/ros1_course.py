# SPDX-License-Identifier: MIT
"""References and goals for ROS 1's own Python: a table's rows, each published when its time has come.

Rows: goal|reference t x y psi u v r. The first has t = 0: when all have subscribed.
"""

import math
import sys
from pathlib import Path

import rosgraph
import rospy
from geometry_msgs.msg import Pose, PoseStamped, TransformStamped
from nav_msgs.msg import Odometry


def placed(x: float, y: float, psi: float) -> Pose:
    pose = Pose()
    pose.position.x, pose.position.y = x, y
    pose.orientation.z, pose.orientation.w = math.sin(psi / 2), math.cos(psi / 2)
    return pose


def transform(
    stamp: rospy.Time, parent: str, child: str, pose: tuple[float, float, float]
) -> TransformStamped:
    made, own = TransformStamped(), placed(*pose)
    made.header.stamp, made.header.frame_id, made.child_frame_id = stamp, parent, child
    made.transform.translation.x, made.transform.translation.y = own.position.x, own.position.y
    made.transform.rotation = own.orientation
    return made


def all_hear(publisher: rospy.Publisher) -> bool:
    """Whether all subscribers that the master knows are connected, the node besides a recorder."""
    known = dict(rosgraph.Master("/course").getSystemState()[1])
    return publisher.get_num_connections() >= len(known.get(publisher.resolved_name, ())) > 0


def main(path: str) -> None:
    """To the end of the table."""
    rospy.init_node("course")
    goals = rospy.Publisher("/goal", PoseStamped, queue_size=10)
    references = rospy.Publisher("/reference", Odometry, queue_size=10)
    while not (all_hear(goals) and all_hear(references)):
        rospy.sleep(0.05)
    begin = rospy.Time.now()
    for line in Path(path).read_text().splitlines():
        kind, *words = line.split()
        t, x, y, psi, u, v, r = map(float, words)
        stamp = begin + rospy.Duration.from_sec(t)
        rospy.sleep(stamp - rospy.Time.now())
        message = PoseStamped() if kind == "goal" else Odometry()
        message.header.stamp, message.header.frame_id = stamp, "map"
        if kind == "goal":
            message.pose = placed(x, y, psi)
            goals.publish(message)
            continue
        message.pose.pose = placed(x, y, psi)
        message.twist.twist.linear.x, message.twist.twist.linear.y = u, v
        message.twist.twist.angular.z = r
        references.publish(message)
    rospy.sleep(0.2)  # for the last one to leave


if __name__ == "__main__":
    main(sys.argv[1])
