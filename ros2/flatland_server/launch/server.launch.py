"""Runs the simulator: ros2 launch flatland_server server.launch.py world_path:=WORLD.yaml."""

from ament_index_python.packages import (
    PackageNotFoundError,
    get_package_prefix,
    get_package_share_directory,
)
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, LogInfo, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration, PythonExpression
from launch_ros.actions import Node

PARAMETERS = (
    ("world_path", "office", "the world's YAML file, or the name of a shipped world"),
    ("update_rate", "200.0", "steps per second of real time [Hz]; inf: as fast as possible"),
    ("step_size", "0.005", "simulated time per step [s]"),
    ("show_viz", "true", "publish markers, and open rviz2 if it is installed"),
    ("viz_pub_rate", "30.0", "how often models' markers are published [Hz]"),
    (
        "history",
        LaunchConfiguration("show_viz"),
        "keep states of the run, for /seek",
    ),
    (
        "control_period",
        "",
        "simulated time of a call of /step_world [s]; by default 0.1",
    ),
    ("train_mode", "false", "time stands still but for /step_world and /step"),
    ("command_age", "inf", "simulated time after a command at which the simulation waits [s]"),
    ("models", "", "folders, separated by colons, where models are looked up"),
    (
        "state_folder",
        "",
        "the folder for saved states; clients then name few other files",
    ),
    ("seed", "0", "seed of all noise; equal seeds give equal runs"),
    ("simplify_map", "0", "simplification of the outlines of map images: 0, 1 or 2"),
    ("no_return", "inf", "range of beams that hit nothing: inf (REP 117), nan, or max"),
    ("static_tf", "true", "send the transforms of sensors once, on /tf_static"),
    ("tf_by_namespace", "false", "transforms of robots in namespaces go to NAMESPACE/tf"),
    ("wall_clock_stamps", "false", "stamps of real time, without /clock"),
    ("realtime_priority", "true", "punctual steps on a busy machine, if the user may have them"),
    (
        "map_to_odom",
        PythonExpression(["'", LaunchConfiguration("world_path"), "' == 'office'"]),
        "publish map -> odom as identity; false for a localiser: AMCL, slam_toolbox",
    ),
    ("map", "false", "publish the first layer on /map, as map_server does"),
    ("odom_topic", "odometry/filtered", "of odometry, for drives without the key odom_pub"),
    ("initial_pose", "", "name of a model that /initialpose moves"),
    ("cmd_vel_type", "", "Twist or TwistStamped; by default that of the distribution's Nav2"),
    ("page_port", "0", "port of a page for the browser; 0: none"),
)
"""The parameters of the node: their names, defaults and meanings."""


def generate_launch_description():
    """The launch file's arguments and nodes."""
    arguments = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, default, text in (
            *PARAMETERS,
            ("use_rviz", "false", "do not open rviz2, for one of your own"),
            ("namespace", "", "of the node, its topics and services"),
        )
    ]
    server = Node(
        package="flatland_server",
        executable="flatland_server",
        name="flatland_server",
        namespace=LaunchConfiguration("namespace"),
        output="screen",
        parameters=[{name: LaunchConfiguration(name) for name, _, _ in PARAMETERS}],
        on_exit=Shutdown(),
    )
    return LaunchDescription([*arguments, server, OpaqueFunction(function=_viewer)])


def _viewer(context):
    """rviz2, if it is wanted and installed. Closing it ends the server."""
    is_wanted, is_own, has_real_time = (
        LaunchConfiguration(name).perform(context).lower() in ("true", "1")
        for name in ("show_viz", "use_rviz", "wall_clock_stamps")
    )
    if not is_wanted or is_own:
        return []
    try:
        get_package_prefix("rviz2")
    except PackageNotFoundError:
        return [LogInfo(msg="rviz2 is not installed: no window; page_port:=9090 serves a page")]
    config = f"{get_package_share_directory('flatland_server')}/rviz/flatland.rviz"
    return [
        Node(
            package="rviz2",
            executable="rviz2",
            arguments=["-d", config],
            parameters=[{"use_sim_time": not has_real_time}],
            on_exit=Shutdown(),
        )
    ]
