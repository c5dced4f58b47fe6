"""A ground robot as a boat: ros2 launch seatrial_odometry mimic.launch.py model:=/path/of/model.yaml"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

ARGUMENTS = (  # name, type, default, description
    ("model", str, None, "path of model.yaml"),
    ("command_topic", str, "", "empty: as the vehicle says"),
    ("speed", float, "0.8", "the carrier's highest [m/s]"),
    ("yaw_rate", float, "2.0", "its highest [rad/s]"),
    ("acceleration", float, "1.5", "its highest [m/s^2]"),
    ("yaw_acceleration", float, "6.0", "its highest [rad/s^2]"),
    ("lag", float, "0.1", "its delay and time constant together [s]"),
    ("use_sim_time", bool, "false", "with a simulator's /clock"),
)
TOPICS = (  # the same
    ("odom", str, "odom", "the carrier's odometry (nav_msgs/Odometry)"),
    ("cmd_vel", str, "cmd_vel", "its velocity (geometry_msgs/Twist)"),
)


def generate_launch_description() -> LaunchDescription:
    """The node."""
    declared = [
        DeclareLaunchArgument(
            name, description=words, **({} if default is None else {"default_value": default})
        )
        for name, _, default, words in (*ARGUMENTS, *TOPICS)
    ]
    values = {
        name: ParameterValue(LaunchConfiguration(name), value_type=kind)
        for name, kind, *_ in ARGUMENTS
    }
    node = Node(
        package="seatrial_odometry", executable="mimic", name="seatrial_mimic",
        output="screen", remappings=[(name, LaunchConfiguration(name)) for name, *_ in TOPICS],
        parameters=[values],
    )  # fmt: skip
    return LaunchDescription([*declared, node])
