"""The launch files for the navigation stack, as roslaunch reads them; the stack is not needed."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from ros_processes import free_port
from roslaunch.config import load_config_default

from flatland_navigation.stack import PACKAGES, missing_packages

pytestmark = pytest.mark.slow

PACKAGE = Path(__file__).resolve().parents[2]
LAUNCH = PACKAGE / "launch"

# http://wiki.ros.org/amcl, section 3.1
AMCL = """min_particles max_particles kld_err kld_z update_min_d update_min_a resample_interval
    transform_tolerance recovery_alpha_slow recovery_alpha_fast initial_pose_x initial_pose_y
    initial_pose_a initial_cov_xx initial_cov_yy initial_cov_aa gui_publish_rate save_pose_rate
    use_map_topic first_map_only selective_resampling laser_min_range laser_max_range
    laser_max_beams laser_z_hit laser_z_short laser_z_max laser_z_rand laser_sigma_hit
    laser_lambda_short laser_likelihood_max_dist laser_model_type odom_model_type odom_alpha1
    odom_alpha2 odom_alpha3 odom_alpha4 odom_alpha5 odom_frame_id base_frame_id global_frame_id
    tf_broadcast"""

# http://wiki.ros.org/move_base, section 1.1.6
MOVE_BASE = """base_global_planner base_local_planner recovery_behaviors controller_frequency
    planner_patience controller_patience conservative_reset_dist recovery_behavior_enabled
    clearing_rotation_allowed shutdown_costmaps oscillation_timeout oscillation_distance
    planner_frequency max_planning_retries"""

# http://wiki.ros.org/costmap_2d, and its pages of layers
COSTMAP = """global_frame robot_base_frame transform_tolerance update_frequency publish_frequency
    rolling_window always_send_full_costmap width height resolution origin_x origin_y plugins
    footprint robot_radius footprint_padding
    static_layer/map_topic static_layer/unknown_cost_value static_layer/lethal_cost_threshold
    static_layer/first_map_only static_layer/subscribe_to_updates static_layer/track_unknown_space
    static_layer/use_maximum static_layer/trinary_costmap
    obstacle_layer/observation_sources obstacle_layer/max_obstacle_height
    obstacle_layer/track_unknown_space obstacle_layer/footprint_clearing_enabled
    obstacle_layer/scan/topic obstacle_layer/scan/sensor_frame
    obstacle_layer/scan/observation_persistence obstacle_layer/scan/expected_update_rate
    obstacle_layer/scan/data_type obstacle_layer/scan/clearing obstacle_layer/scan/marking
    obstacle_layer/scan/max_obstacle_height obstacle_layer/scan/min_obstacle_height
    obstacle_layer/scan/obstacle_range obstacle_layer/scan/raytrace_range
    obstacle_layer/scan/inf_is_valid
    inflation_layer/inflation_radius inflation_layer/cost_scaling_factor"""

# http://wiki.ros.org/dwa_local_planner, with the names that ROS Melodic and Noetic have
DWA = """acc_lim_x acc_lim_y acc_lim_theta acc_lim_trans max_vel_trans min_vel_trans max_vel_x
    min_vel_x max_vel_y min_vel_y max_vel_theta min_vel_theta yaw_goal_tolerance xy_goal_tolerance
    latch_xy_goal_tolerance sim_time sim_granularity angular_sim_granularity vx_samples vy_samples
    vth_samples controller_frequency path_distance_bias goal_distance_bias occdist_scale
    twirling_scale forward_point_distance stop_time_buffer scaling_speed max_scaling_factor
    publish_cost_grid oscillation_reset_dist oscillation_reset_angle prune_plan trans_stopped_vel
    theta_stopped_vel odom_topic"""

# http://wiki.ros.org/gmapping, section 4.1.4
GMAPPING = """inverted_laser throttle_scans base_frame map_frame odom_frame map_update_interval
    maxUrange sigma kernelSize lstep astep iterations lsigma ogain lskip minimumScore srr srt str
    stt linearUpdate angularUpdate temporalUpdate resampleThreshold particles xmin ymin xmax ymax
    delta llsamplerange llsamplestep lasamplerange lasamplestep transform_publish_period occ_thresh
    maxRange"""

# Topics that nav.rviz shows: of the stack's pages, the navigator and the server.
TOPICS = """/map scan initialpose amcl_pose particlecloud move_base_simple/goal
    move_base/current_goal move_base/plan move_base/NavfnROS/plan move_base/DWAPlannerROS/local_plan
    move_base/global_costmap/costmap move_base/local_costmap/costmap
    /flatland_server/debug/layer/map /flatland_server/debug/models"""

DOCUMENTED = {
    "amcl": {*AMCL.split()},
    "move_base": {
        *MOVE_BASE.split(),
        *(f"global_costmap/{name}" for name in COSTMAP.split()),
        *(f"local_costmap/{name}" for name in COSTMAP.split()),
        *(f"DWAPlannerROS/{name}" for name in DWA.split()),
    },
    "map_server": {"frame_id"},
}


@pytest.fixture
def stack(tmp_path, monkeypatch):
    """Empty packages with the stack's names."""
    for name in PACKAGES:
        folder = tmp_path / name
        folder.mkdir()
        (folder / "package.xml").write_text(
            f'<package format="2"><name>{name}</name><version>1.0.0</version>'
            "<description/><maintainer email='a@b.c'>a</maintainer><license>a</license></package>"
        )
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"{tmp_path}:{os.environ['ROS_PACKAGE_PATH']}")


def load(name, *arguments):
    """The configuration that roslaunch makes of a launch file and arguments."""
    return load_config_default([(str(LAUNCH / name), list(arguments))], None, verbose=False)


def nodes_of(config):
    """The nodes by their full names."""
    return {f"{node.namespace}{node.name}": node for node in config.nodes}


def params_of(config, node):
    """A node's parameters, by their names in it."""
    prefix = f"{node}/"
    return {
        name[len(prefix) :]: param.value
        for name, param in config.params.items()
        if name.startswith(prefix)
    }


def remaps_of(node):
    return {(source, end) for source, end in node.remap_args}


def test_one_robot_without_a_namespace(stack):
    config = load("navigation.launch")
    amcl, move_base = params_of(config, "/amcl"), params_of(config, "/move_base")

    assert sorted(nodes_of(config)) == ["/amcl", "/map_server", "/move_base"]
    assert (amcl["odom_frame_id"], amcl["base_frame_id"]) == ("odom", "base_link")
    assert move_base["global_costmap/robot_base_frame"] == "base_link"
    assert move_base["local_costmap/robot_base_frame"] == "base_link"
    assert move_base["local_costmap/global_frame"] == "odom"


def test_one_robot_in_a_namespace(stack):
    """Its frames are those of a Flatland model with a drive that has odom_frame_id: ~odom."""
    config = load("navigation.launch", "ns:=r1", "x:=1.5", "y:=-2", "yaw:=0.5")
    nodes = nodes_of(config)
    amcl, move_base = params_of(config, "/r1/amcl"), params_of(config, "/r1/move_base")

    assert sorted(nodes) == ["/map_server", "/r1/amcl", "/r1/move_base"]
    assert amcl["global_frame_id"] == "map"
    assert (amcl["odom_frame_id"], amcl["base_frame_id"]) == ("r1_odom", "r1_base_link")
    assert [amcl[f"initial_pose_{key}"] for key in "xya"] == [1.5, -2, 0.5]
    assert remaps_of(nodes["/r1/amcl"]) == {("static_map", "/static_map")}
    assert move_base["global_costmap/robot_base_frame"] == "r1_base_link"
    assert move_base["local_costmap/robot_base_frame"] == "r1_base_link"
    assert move_base["global_costmap/robot_radius"] == 0.18
    assert move_base["global_costmap/global_frame"] == "map"
    assert move_base["local_costmap/global_frame"] == "r1_odom"
    assert move_base["global_costmap/static_layer/map_topic"] == "/map"
    assert ("odom", "odometry/filtered") in remaps_of(nodes["/r1/move_base"])


def test_costmaps_take_inf_and_late_transforms(stack):
    config = load("navigation.launch", "ns:=r1")
    move_base = params_of(config, "/r1/move_base")

    assert params_of(config, "/r1/amcl")["transform_tolerance"] == 0.5
    for costmap in ("global_costmap", "local_costmap"):
        source = f"{costmap}/obstacle_layer/scan"
        assert move_base[f"{source}/inf_is_valid"] is True
        assert move_base[f"{source}/topic"] == "scan"  # within the namespace
        assert move_base[f"{costmap}/transform_tolerance"] == 0.5


def test_two_robots_share_a_map_server(stack):
    config = load("two_robots.launch")
    nodes = nodes_of(config)

    expected = [f"/{r}/{n}" for r in ("r1", "r2") for n in ("amcl", "move_base", "spawn_robot")]
    assert sorted(nodes) == sorted([*expected, "/map_server"])
    for robot in ("r1", "r2"):
        spawn, amcl = (params_of(config, f"/{robot}/{name}") for name in ("spawn_robot", "amcl"))
        assert spawn["namespace"] == robot
        assert (spawn["x"], spawn["y"]) == (amcl["initial_pose_x"], amcl["initial_pose_y"])
        assert spawn["yaw"] == amcl["initial_pose_a"]
        assert amcl["odom_frame_id"] == f"{robot}_odom"


def test_two_robots_without_the_stack():
    config = load("two_robots.launch", "navigator:=waypoints", "waypoints_1:=[[1, 0, 0]]")
    nodes = nodes_of(config)

    expected = [f"/{r}/{name}" for r in ("r1", "r2") for name in ("move_base", "spawn_robot")]
    assert sorted(nodes) == sorted([*expected, "/r1/send_goals"])
    assert {node.package for node in config.nodes} == {"flatland_navigation"}
    assert nodes["/r1/move_base"].type == "navigator"


@pytest.mark.parametrize("namespace", ["", "r1"])
def test_every_parameter_of_the_stack_is_documented(stack, namespace):
    config = load("navigation.launch", f"ns:={namespace}")

    for name, documented in DOCUMENTED.items():
        inside = f"/{namespace}" if namespace and name != "map_server" else ""
        params = params_of(config, f"{inside}/{name}")
        assert params
        assert set(params) - documented == set()


@pytest.mark.parametrize("namespace", ["", "r1"])
def test_mapping_has_the_robots_frames_and_documented_parameters(namespace):
    config = load("mapping.launch", f"ns:={namespace}")
    [node] = nodes_of(config)
    params = params_of(config, node)

    prefix = f"{namespace}_" if namespace else ""
    assert params["base_frame"] == f"{prefix}base_link"
    assert params["odom_frame"] == f"{prefix}odom"
    assert set(params) - {*GMAPPING.split()} == set()


def test_rviz_shows_known_topics_of_its_namespace():
    config = load("rviz.launch", "ns:=r1")
    [rviz] = config.nodes
    shown = yaml.safe_load((PACKAGE / "rviz" / "nav.rviz").read_text())["Visualization Manager"]

    assert (rviz.namespace, rviz.package) == ("/r1/", "rviz")
    assert str(PACKAGE / "rviz" / "nav.rviz") in rviz.args
    entries = [*shown["Displays"], *shown["Tools"]]
    topics = {entry.get("Topic", entry.get("Marker Topic")) for entry in entries} - {None}
    assert topics == {*TOPICS.split()}
    assert shown["Global Options"]["Fixed Frame"] == "map"


def test_waypoints_may_come_from_a_file():
    goals = PACKAGE / "config" / "office_goals.yaml"
    config = load("waypoints.launch", "ns:=r1", f"goals_file:={goals}", "loop:=true")
    params = params_of(config, "/r1/send_goals")

    assert all(len(goal) == 3 for goal in params["goals"])
    assert params["loop"] is True
    assert load("waypoints.launch").nodes[0].name == "move_base"


@pytest.mark.skipif(not missing_packages(), reason="the navigation stack is installed")
@pytest.mark.parametrize("launch", [["navigation.launch"], ["robot.launch", "ns:=r1"]])
def test_without_the_stack_one_line_says_so_and_nothing_starts(launch):
    port = free_port()
    result = subprocess.run(
        [
            *(sys.executable, shutil.which("roslaunch")),
            *("-p", str(port), "flatland_navigation", *launch),
        ],
        env={**os.environ, "ROS_MASTER_URI": f"http://127.0.0.1:{port}"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=60,
    )

    [line] = [each for each in result.stdout.splitlines() if "navigation stack" in each]
    assert line == (
        "flatland_navigation: the navigation stack is not installed (missing: "
        f"{', '.join(missing_packages())}); "
        "waypoints.launch and navigator:=waypoints need none of it"
    )
    assert result.returncode == 1
    assert "process[" not in result.stdout
    assert "started roslaunch server" not in result.stdout


def test_the_filter_has_the_robots_frames_topics_and_start():
    config = load("ekf.launch", "ns:=r1", "x:=2.0", "yaw:=0.5")
    ekf = params_of(config, "/r1/ekf")

    assert (ekf["odom_frame"], ekf["base_link_frame"]) == ("r1_odom", "r1_base_link")
    assert (ekf["odom0"], ekf["imu0"]) == ("wheel_odom", "imu/data")  # of the realistic robot
    assert ekf["initial_state"][:6] == [2.0, 0.0, 0.0, 0.0, 0.0, 0.5]
    # Velocities alone: the wheels' pose is their integral.
    assert not any(ekf["odom0_config"][:6])
    assert len(ekf["odom0_config"]) == len(ekf["imu0_config"]) == len(ekf["initial_state"]) == 15
    assert remaps_of(nodes_of(config)["/r1/ekf"]) == {("odometry/filtered", "odometry/filtered")}


def test_with_gps_a_second_filter_localises_in_the_map(stack):
    config = load("robot.launch", "ns:=r1", "x:=2.0", "yaw:=0.5", "ekf:=true", "gps:=true")
    ekf, navsat = params_of(config, "/r1/ekf_map"), params_of(config, "/r1/navsat_transform")

    assert (ekf["world_frame"], ekf["odom_frame"]) == ("map", "r1_odom")
    assert ekf["base_link_frame"] == "r1_base_link"
    assert (ekf["odom0"], ekf["odom1"], ekf["imu0"]) == ("wheel_odom", "odometry/gps", "imu/data")
    assert ekf["initial_state"][:6] == [2.0, 0.0, 0.0, 0.0, 0.0, 0.5]
    assert ekf["odom1_config"] == [True, True] + 13 * [False]
    assert len(ekf["process_noise_covariance"]) == 15 * 15
    assert navsat["datum"] == [0.0, 0.0, 0.0]  # the defaults of Gps
    assert navsat["wait_for_datum"] is navsat["use_local_cartesian"] is True
    for name in ("ekf_map", "navsat_transform"):
        remaps = remaps_of(nodes_of(config)[f"/r1/{name}"])
        assert remaps == {("odometry/filtered", "odometry/filtered_map")}
    assert "/r1/ekf_map" not in nodes_of(load("ekf.launch", "ns:=r1"))


def test_one_localiser_sends_map_to_odom(stack):
    for localiser, *arguments in (
        ("amcl",),
        ("ekf_map", "gps:=true"),
        ("ekf_map", "gps:=true", "ekf:=true", "navigator:=waypoints"),
        ("", "navigator:=waypoints"),
    ):
        config = load("robot.launch", "ns:=r1", *arguments)
        found = {"/r1/amcl", "/r1/ekf_map"} & {*nodes_of(config)}
        assert found == ({f"/r1/{localiser}"} if localiser else set())


def test_either_the_filter_or_the_drive_sends_the_transform(stack):
    for ekf, *arguments in ((True, "ekf:=true"), (True, "gps:=true"), (False,)):
        config = load("robot.launch", "ns:=r1", *arguments)
        assert config.params["/wheel_odom_tf"].value is not ekf
        assert ("/r1/ekf" in nodes_of(config)) == ekf


def test_the_score_is_there_if_asked_for(stack):
    for score in (True, False):
        config = load("robot.launch", "ns:=r1", f"score:={str(score).lower()}")
        assert ("/r1/score" in nodes_of(config)) == score
