# SPDX-License-Identifier: MIT
"""Odometry by an identified model: ros2 launch seatrial_odometry odometry.launch.py model:=/path/of/model.yaml"""

from launch import LaunchDescription
from seatrial_odometry.node_launch import node_launch

ARGUMENTS = (  # name, type, description (default of the node)
    ("model", str, "path of model.yaml"),
    ("pose_topic", str, "empty: as the vehicle says"),
    ("command_topic", str, "empty: as the vehicle says"),
    ("odom_frame", str, "frame that drifts and never jumps (odom)"),
    ("base_frame", str, "frame of the boat (base_link)"),
    ("map_frame", str, "frame of the poses; empty: as their messages say"),
    ("rate", float, "of the odometry [Hz]; 0: after every command (50)"),
    ("window", float, "how late or how early an input may be stamped [s] (0.5)"),
    ("publish_tf", bool, "odom_frame to base_frame (true)"),
    ("publish_map_to_odom", bool, "only where nobody else does (false)"),
    ("use_sim_time", bool, "with a simulator's /clock (false)"),
)


def generate_launch_description() -> LaunchDescription:
    """Arguments, and the node."""
    return node_launch("odometry", ARGUMENTS, respawn=True)
