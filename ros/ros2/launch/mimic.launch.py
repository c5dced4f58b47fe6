# SPDX-License-Identifier: MIT
"""A ground robot as a boat: ros2 launch seatrial_odometry mimic.launch.py model:=/path/of/model.yaml"""

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

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
            package="seatrial_odometry", executable="mimic", name="seatrial_mimic",
            namespace=LaunchConfiguration("namespace"), output="screen",
            remappings=[(name, LaunchConfiguration(name)) for name, _ in TOPICS],
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
        *(DeclareLaunchArgument(n, default_value=n, description=words) for n, words in TOPICS),
        OpaqueFunction(function=start),
    ])  # fmt: skip
