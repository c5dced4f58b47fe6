# SPDX-License-Identifier: MIT
"""One node with its parameters as launch arguments."""

from collections.abc import Sequence
from functools import partial

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

Arguments = Sequence[tuple[str, type, str]]  # parameter, type, description (default of the node)
Topics = Sequence[tuple[str, str]]  # name and default, description
RESPAWN_DELAY = 2.0  # [s]


def node_launch(
    executable: str, arguments: Arguments, topics: Topics = (), *, respawn: bool = False
) -> LaunchDescription:
    """Arguments, and the node. What is not given stays as in the parameter file, else as the node has it."""
    start = partial(_start, executable, arguments, topics, respawn)
    return LaunchDescription([
        DeclareLaunchArgument("namespace", default_value="", description="of the node and its topics"),
        DeclareLaunchArgument("params", default_value="", description="path of a parameter file"),
        *(DeclareLaunchArgument(name, default_value="", description=words)
          for name, _, words in arguments),
        *(DeclareLaunchArgument(n, default_value=n, description=words) for n, words in topics),
        OpaqueFunction(function=start),
    ])  # fmt: skip


def _start(
    executable: str, arguments: Arguments, topics: Topics, respawn: bool, context: LaunchContext
) -> list[Node]:
    names = ("params", *(name for name, _, _ in arguments))
    given = {name: LaunchConfiguration(name) for name in names}
    given = {name: value for name, value in given.items() if value.perform(context)}
    values = {
        name: ParameterValue(given[name], value_type=kind)
        for name, kind, _ in arguments if name in given
    }  # fmt: skip
    return [
        Node(
            package="seatrial_odometry", executable=executable, name=f"seatrial_{executable}",
            namespace=LaunchConfiguration("namespace"), output="screen",
            respawn=respawn, respawn_delay=RESPAWN_DELAY,
            remappings=[(name, LaunchConfiguration(name)) for name, _ in topics],
            parameters=[*([given["params"]] if "params" in given else []), values],
        )
    ]  # fmt: skip
