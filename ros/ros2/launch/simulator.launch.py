"""A simulated boat: ros2 launch seatrial_odometry simulator.launch.py models:=/path/of/model.yaml"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

ARGUMENTS = (  # name, type, default, description
    ("models", str, None, "path of model.yaml, or several with commas between"),
    ("scene", str, "", "path of scene.yaml; empty: open water"),
    ("real_time_factor", float, "1.0", "simulated seconds in a second"),
    ("rate", float, "50.0", "of the truth [Hz]"),
    ("publish_clock", bool, "true", "/clock; the other nodes then have use_sim_time"),
)


def generate_launch_description() -> LaunchDescription:
    """The node; those that live on its clock have use_sim_time:=true."""
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
        package="seatrial_odometry", executable="simulator", name="seatrial_simulator",
        output="screen", parameters=[values],
    )  # fmt: skip
    return LaunchDescription([*declared, node])
