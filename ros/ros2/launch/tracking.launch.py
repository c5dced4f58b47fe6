"""A boat along a reference, beside odometry.launch.py:
ros2 launch seatrial_odometry tracking.launch.py model:=/path/of/model.yaml gains:=/path/of/gains.yaml
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

ARGUMENTS = (  # name, type, default, description
    ("model", str, None, "path of model.yaml"),
    ("gains", str, None, "path of gains.yaml, as `seatrial tune -o` writes it"),
    ("command_topic", str, "", "empty: as the vehicle says"),
    ("control_in_map", bool, "true", "by map_pose; false: by odom, references are then in odom"),
    ("timeout", float, "0.5", "age of odometry from which commands are zero [s]"),
    ("reference_timeout", float, "0.5", "the same of the reference [s]"),
    ("use_sim_time", bool, "false", "with a simulator's /clock"),
)


def generate_launch_description() -> LaunchDescription:
    """The node."""
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
        package="seatrial_odometry", executable="tracking", name="seatrial_tracking",
        output="screen", parameters=[values],
    )  # fmt: skip
    return LaunchDescription([*declared, node])
