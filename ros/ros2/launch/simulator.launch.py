# SPDX-License-Identifier: MIT
"""A simulated boat: ros2 launch seatrial_odometry simulator.launch.py models:=/path/of/model.yaml"""

from launch import LaunchDescription
from seatrial_odometry.node_launch import node_launch

ARGUMENTS = (  # name, type, description (default of the node)
    ("models", str, "path of model.yaml, or several with commas between"),
    ("scene", str, "path of scene.yaml; empty: open water"),
    ("map_frame", str, "frame of poses and truth (map)"),
    ("base_frame", str, "frame of the boat (base_link)"),
    ("laser_frame", str, "frame of the LiDAR (laser)"),
    ("real_time_factor", float, "simulated seconds in a second (1)"),
    ("rate", float, "of the truth [Hz] (50)"),
    ("publish_clock", bool, "/clock; the other nodes then have use_sim_time (true)"),
)


def generate_launch_description() -> LaunchDescription:
    """Arguments, and the node."""
    return node_launch("simulator", ARGUMENTS)
