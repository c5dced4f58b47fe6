"""slam_toolbox on the odometry of an identified model.

    ros2 launch seatrial_odometry slam.launch.py model:=/path/of/model.yaml

Expected besides: the LiDAR's driver (/scan), and base_link to its frame on tf. See docs/slam.md.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

OWN = FindPackageShare("seatrial_odometry")
ARGUMENTS = (  # name, default, description
    ("model", None, "path of model.yaml"),
    ("command_topic", "", "empty: as the vehicle says"),
    ("pose_topic", "pose", "slam_toolbox's PoseWithCovarianceStamped"),
    (
        "slam_params_file",
        PathJoinSubstitution([OWN, "config", "slam_toolbox.yaml"]),
        "slam_toolbox's",
    ),
    ("use_sim_time", "false", "with a simulator's /clock"),
)


def generate_launch_description() -> LaunchDescription:
    """The odometry node, and slam_toolbox by its own launch file."""
    declared = [
        DeclareLaunchArgument(
            name, description=words, **({} if default is None else {"default_value": default})
        )
        for name, default, words in ARGUMENTS
    ]
    given = {name: LaunchConfiguration(name) for name, *_ in ARGUMENTS}
    texts = ("model", "command_topic", "pose_topic")
    odometry = Node(
        package="seatrial_odometry", executable="odometry", name="seatrial_odometry",
        output="screen", respawn=True, respawn_delay=2.0,
        parameters=[{
            **{name: ParameterValue(given[name], value_type=str) for name in texts},
            "use_sim_time": ParameterValue(given["use_sim_time"], value_type=bool),
            # slam_toolbox publishes map to odom itself, up to the present time
            "publish_map_to_odom": False,
        }],
    )  # fmt: skip
    slam = IncludeLaunchDescription(
        PythonLaunchDescriptionSource(
            PathJoinSubstitution(
                [FindPackageShare("slam_toolbox"), "launch", "online_async_launch.py"]
            )
        ),
        launch_arguments=[(name, given[name]) for name in ("use_sim_time", "slam_params_file")],
    )
    return LaunchDescription([*declared, odometry, slam])
