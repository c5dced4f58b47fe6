# SPDX-License-Identifier: MIT
"""A boat along a reference, beside odometry.launch.py:
ros2 launch seatrial_odometry tracking.launch.py model:=/path/of/model.yaml gains:=/path/of/gains.yaml
"""

from launch import LaunchDescription
from seatrial_odometry.node_launch import node_launch

ARGUMENTS = (  # name, type, description (default of the node)
    ("model", str, "path of model.yaml"),
    ("gains", str, "path of gains.yaml, as `seatrial tune -o` writes it"),
    ("command_topic", str, "empty: as the vehicle says"),
    ("control_in_map", bool, "by map_pose; false: by odom, references are then in odom (true)"),
    ("timeout", float, "age of odometry from which commands are zero [s] (0.5)"),
    ("reference_timeout", float, "the same of the reference [s] (0.5)"),
    ("use_sim_time", bool, "with a simulator's /clock (false)"),
)


def generate_launch_description() -> LaunchDescription:
    """Arguments, and the node."""
    return node_launch("tracking", ARGUMENTS)
