# SPDX-License-Identifier: MIT
"""A ground robot as a boat: ros2 launch seatrial_odometry mimic.launch.py model:=/path/of/model.yaml"""

from launch import LaunchDescription
from seatrial_odometry.node_launch import node_launch

ARGUMENTS = (  # name, type, description (default of the node)
    ("model", str, "path of model.yaml"),
    ("command_topic", str, "empty: as the vehicle says"),
    ("enable_stamped_cmd_vel", bool, "cmd_vel is TwistStamped, not Twist (false)"),
    ("speed", float, "the carrier's highest [m/s] (0.8)"),
    ("yaw_rate", float, "its highest [rad/s] (2)"),
    ("acceleration", float, "its highest [m/s^2] (1.5)"),
    ("yaw_acceleration", float, "its highest [rad/s^2] (6)"),
    ("lag", float, "its delay and time constant together [s] (0.1)"),
    ("use_sim_time", bool, "with a simulator's /clock (false)"),
)
TOPICS = (  # name and default, description
    ("odom", "the carrier's odometry (nav_msgs/Odometry)"),
    ("cmd_vel", "its velocity (geometry_msgs/Twist)"),
)


def generate_launch_description() -> LaunchDescription:
    """Arguments, and the node."""
    return node_launch("mimic", ARGUMENTS, TOPICS)
