# SPDX-License-Identifier: MIT
"""A boat along a reference, beside odometry.launch.py:
ros2 launch seatrial_odometry tracking.launch.py model:=/path/of/model.yaml gains:=/path/of/gains.yaml
"""

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

ARGUMENTS = (  # name, type, description (default of the node)
    ("model", str, "path of model.yaml"),
    ("gains", str, "path of gains.yaml, as `seatrial tune -o` writes it"),
    ("command_topic", str, "empty: as the vehicle says"),
    ("control_in_map", bool, "by map_pose; false: by odom, references are then in odom (true)"),
    ("timeout", float, "age of odometry from which commands are zero [s] (0.5)"),
    ("reference_timeout", float, "the same of the reference [s] (0.5)"),
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
            package="seatrial_odometry", executable="tracking", name="seatrial_tracking",
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
