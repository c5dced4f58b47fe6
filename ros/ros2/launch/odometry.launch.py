"""Odometry by an identified model: ros2 launch seatrial_odometry odometry.launch.py model:=/path/of/model.yaml"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

ARGUMENTS = (  # name, type, default, description
    ("model", str, None, "path of model.yaml"),
    ("pose_topic", str, "", "empty: as the vehicle says"),
    ("command_topic", str, "", "empty: as the vehicle says"),
    ("rate", float, "50.0", "of the odometry [Hz]; 0: after every command"),
    ("publish_tf", bool, "true", "odom to base_link"),
    ("publish_map_to_odom", bool, "false", "only where nobody else does"),
    ("use_sim_time", bool, "false", "with a simulator's /clock"),
)


def generate_launch_description() -> LaunchDescription:
    """The node, started anew where it ends."""
    declared = [
        DeclareLaunchArgument(
            name, description=words, **({} if default is None else {"default_value": default})
        )
        for name, _, default, words in ARGUMENTS
    ]
    values = {
        name: ParameterValue(LaunchConfiguration(name), value_type=kind)
        for name, kind, *_ in ARGUMENTS
    }
    node = Node(
        package="seatrial_odometry", executable="odometry", name="seatrial_odometry",
        output="screen", respawn=True, parameters=[values],
    )  # fmt: skip
    return LaunchDescription([*declared, node])
