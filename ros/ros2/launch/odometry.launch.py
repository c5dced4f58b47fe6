# SPDX-License-Identifier: MIT
"""Odometry by an identified model: ros2 launch seatrial_odometry odometry.launch.py model:=/path/of/model.yaml"""

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

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
            package="seatrial_odometry", executable="odometry", name="seatrial_odometry",
            namespace=LaunchConfiguration("namespace"), output="screen",
            respawn=True, respawn_delay=2.0,  # [s]
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
