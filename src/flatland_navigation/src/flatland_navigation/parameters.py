"""The private parameters of the nodes, checked."""

import math
from pathlib import Path
from typing import Any, List, NamedTuple, Tuple

import numpy as np
import rospy
import yaml

from flatland_navigation.follower import FollowerConfig
from flatland_navigation.grid import Grid
from flatland_navigation.navigator import NavigatorConfig
from flatland_server import FlatlandError, Pose, Segments, WorldConfig
from flatland_server.hub import positive_param

POSE_SOURCES = ("ground_truth", "tf")


class NodeParameters(NamedTuple):
    """The private parameters of the node navigator."""

    world_path: Path
    layers: Tuple[str, ...]
    resolution: float
    clearance: float
    pose_source: str
    odom_topic: str
    map_frame: str
    control_period: float
    navigator: NavigatorConfig

    @classmethod
    def read(cls) -> "NodeParameters":
        """Reads and checks them.

        Raises:
            FlatlandError: one is missing or invalid.
        """
        world_path = str(rospy.get_param("~world_path", "")) or str(
            rospy.get_param("/flatland_server/world_path", "")
        )
        if not world_path:
            raise FlatlandError(
                "no world: start the server first (roslaunch flatland_server server.launch), "
                "or set ~world_path"
            )
        pose_source = rospy.get_param("~pose_source", "ground_truth")
        if pose_source not in POSE_SOURCES:
            raise FlatlandError(
                f"~pose_source: expected {' or '.join(POSE_SOURCES)}, found {pose_source}"
            )
        layers = rospy.get_param("~layers", [])
        if not isinstance(layers, list) or not all(isinstance(name, str) for name in layers):
            raise FlatlandError(f"~layers: expected a list of names, found {layers}")
        default, speeds = NavigatorConfig(), FollowerConfig()
        return cls(
            Path(world_path),
            tuple(layers),
            _positive("resolution", 0.1),
            _positive("clearance", 0.07),
            str(pose_source),
            str(rospy.get_param("~odom_topic", "odometry/filtered")),
            str(rospy.get_param("~map_frame", "map")),
            1.0 / _positive("control_rate", 20.0),
            NavigatorConfig(
                robot_radius=_positive("robot_radius", default.robot_radius),
                stop_margin=_positive("stop_margin", default.stop_margin),
                replan_after=_positive("replan_after", default.replan_after),
                stuck_after=_positive("stuck_after", default.stuck_after),
                follower=FollowerConfig(
                    max_speed=_positive("max_speed", speeds.max_speed),
                    max_turn_rate=_positive("max_turn_rate", speeds.max_turn_rate),
                    deceleration=_positive("deceleration", speeds.deceleration),
                    lookahead=_positive("lookahead", speeds.lookahead),
                    xy_goal_tolerance=_positive("xy_goal_tolerance", speeds.xy_goal_tolerance),
                    yaw_goal_tolerance=_positive("yaw_goal_tolerance", speeds.yaw_goal_tolerance),
                ),
            ),
        )

    def read_grid(self) -> Grid:
        """Reads the world's walls.

        Raises:
            FlatlandError: the world cannot be read, or has no such walls.
        """
        walls = read_walls(self.world_path, self.layers)
        try:
            return Grid.from_walls(
                walls, self.navigator.robot_radius + self.clearance, self.resolution
            )
        except ValueError as error:
            raise FlatlandError(f"{self.world_path}: {error}") from None


def read_walls(world_path: Path, layers: Tuple[str, ...] = ()) -> Segments:
    """The walls of a world's layers.

    Args:
        world_path: the world file.
        layers: names of layers; empty for all.

    Returns:
        Shape (n, 4), x1, y1, x2, y2 [m].

    Raises:
        FlatlandError: the world cannot be read, or has no layer of a name.
    """
    config = WorldConfig.from_file(world_path)
    known = {name for layer in config.layers for name in layer.names}
    for name in layers:
        if name not in known:
            raise FlatlandError(
                f'~layers: {world_path} has no layer "{name}"; it has {sorted(known)}'
            )
    chosen = [each for each in config.layers if not layers or set(layers) & set(each.names)]
    return np.concatenate([np.empty((0, 4)), *(config.walls_of(layer) for layer in chosen)])


def read_goals() -> List[Pose]:
    """The goals of the node send_goals: `~goals`, a list of [x, y, yaw], or the same as YAML.

    Raises:
        FlatlandError: there are none, or one is not of that form.
    """
    value: Any = rospy.get_param("~goals", None)
    if isinstance(value, str):
        try:
            value = yaml.safe_load(value)
        except yaml.YAMLError:
            raise FlatlandError(f"~goals: expected [[x, y, yaw], ...], found {value}") from None
    if not isinstance(value, list) or not value:
        raise FlatlandError(f"~goals: expected [[x, y, yaw], ...], found {value}")
    return [_goal(index, each) for index, each in enumerate(value)]


def _goal(index: int, value: Any) -> Pose:
    try:
        pose = Pose(*(float(number) for number in value))
    except (TypeError, ValueError):
        pose = Pose(math.nan)
    if not pose.is_finite() or len(value) != 3:
        raise FlatlandError(f"~goals[{index}]: expected [x, y, yaw], found {value}")
    return pose


def read_number(name: str, default: float) -> float:
    """A private parameter that is a finite number.

    Raises:
        FlatlandError: it is something else.
    """
    value: Any = rospy.get_param(f"~{name}", default)
    try:
        number = math.nan if isinstance(value, bool) else float(value)
    except (TypeError, ValueError):
        number = math.nan
    if math.isfinite(number):
        return number
    raise FlatlandError(f"~{name}: expected a number, found {value}")


def _positive(name: str, default: float) -> float:
    return positive_param(rospy.get_param, f"~{name}", default)
