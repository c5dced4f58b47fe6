# SPDX-License-Identifier: MIT
"""Records a trial: ros2 launch docs/recording/record.launch.py pose:=/slam/pose commands:=/joy.

Ctrl-C ends it. See docs/recording.md.
"""

import time

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction
from launch.substitutions import LaunchConfiguration


def generate_launch_description() -> LaunchDescription:
    """Arguments, and one recorder."""
    folder = time.strftime("run_%Y-%m-%d-%H-%M-%S")
    return LaunchDescription(
        [
            _argument("pose", "/slam/pose", "topic of the poses"),
            _argument("commands", "/joy", "topic of the commands; several with spaces between"),
            _argument("extra", "/tf /tf_static", "other topics to keep"),
            _argument("output", folder, "folder to write to; must not exist"),
            OpaqueFunction(function=_record),
        ]
    )


def _argument(name: str, default: str, description: str) -> DeclareLaunchArgument:
    return DeclareLaunchArgument(name, default_value=default, description=description)


def _record(context: LaunchContext) -> list[ExecuteProcess]:
    pose, commands, extra, output = (
        LaunchConfiguration(name).perform(context)
        for name in ("pose", "commands", "extra", "output")
    )
    topics = f"{pose} {commands} {extra}".split()
    record = ["ros2", "bag", "record", "--storage", "mcap", "--output", output, *topics]
    return [ExecuteProcess(cmd=record, output="screen")]
