# SPDX-License-Identifier: MIT
"""A simulated boat: ros2 launch seatrial_odometry simulator.launch.py models:=/path/of/model.yaml"""

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

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


def start(context: LaunchContext) -> list[Node]:
    """The node. What is not given stays as in the parameter file, else as the node has it."""
    given = {name: LaunchConfiguration(name) for name in ("params", *(a[0] for a in ARGUMENTS))}
    given = {name: value for name, value in given.items() if value.perform(context)}
    values = {
        name: ParameterValue(given[name], value_type=kind)
        for name, kind, _ in ARGUMENTS if name in given
    }  # fmt: skip
    return [
        Node(
            package="seatrial_odometry", executable="simulator", name="seatrial_simulator",
            namespace=LaunchConfiguration("namespace"), output="screen",
            parameters=[*([given["params"]] if "params" in given else []), values],
        )
    ]  # fmt: skip


def generate_launch_description() -> LaunchDescription:
    """Arguments, and the node."""
    return LaunchDescription([
        DeclareLaunchArgument("namespace", default_value="", description="of the node and its topics"),
        DeclareLaunchArgument("params", default_value="", description="path of a parameter file"),
        *(DeclareLaunchArgument(name, default_value="", description=words)
          for name, _, words in ARGUMENTS),
        OpaqueFunction(function=start),
    ])  # fmt: skip
