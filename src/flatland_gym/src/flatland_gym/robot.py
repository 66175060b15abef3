"""The robot of a world: which model is driven, and the facts of it that environments need."""

import math
from dataclasses import dataclass
from typing import Any, Dict, List, Tuple

import numpy as np
from gymnasium import spaces

from flatland_gym.settings import NavigationSettings
from flatland_server import FloatArray, UsageError

DRIVES = ("DiffDrive", "OmniDrive", "TricycleDrive")

Content = Dict[str, Any]
"""A world, a model or a plugin as plain data; see `flatland_server.world_content`."""


@dataclass(frozen=True)
class Robot:
    """The robot of a world.

    Attributes:
        name: of the model.
        drive: the name of its drive.
        lidar: the name of its lidar.
        max_range: of the lidar [m].
        beams: of the lidar.
        action_limits: the largest value of each part of an action; the least is its negative.
        velocity_limits: of forwards, to the left and turning [m/s, m/s, rad/s]; 0 for a direction
            in which it cannot be driven.
    """

    name: str
    drive: str
    lidar: str
    max_range: float
    beams: int
    action_limits: Tuple[float, ...]
    velocity_limits: Tuple[float, float, float]

    @property
    def actions(self) -> FloatArray:
        """`action_limits` as an array."""
        return np.array(self.action_limits)

    def action_space(self) -> spaces.Box:
        """The commands of the drive in its own units, within its limits: a new space."""
        high = self.actions.astype(np.float32)
        return spaces.Box(-high, high, dtype=np.float32)


def find_robot(content: Content, settings: NavigationSettings) -> Tuple[Content, Content, Content]:
    """The entries of the robot, of its drive and of its lidar in a world.

    Raises:
        UsageError: there is none, or there are several and the settings do not say which.
    """
    entries = {entry["name"]: entry for entry in content["models"]}
    if settings.robot is not None and settings.robot not in entries:
        raise UsageError(f'there is no model "{settings.robot}"; there are: {_names(entries)}')
    names = [settings.robot] if settings.robot is not None else list(entries)
    usable = [n for n in names if _of(entries[n], DRIVES) and _of(entries[n], ("Laser",))]
    if not usable:
        found = "; ".join(f"{name} has {_kinds(entries[name])}" for name in names) or "no models"
        raise UsageError(
            f"expected a model with a drive ({', '.join(DRIVES)}) and a Laser, found: {found}"
        )
    if len(usable) > 1:
        raise UsageError(f"expected the argument robot, one of: {', '.join(usable)}")
    robot = entries[usable[0]]
    drives, lidars = _of(robot, DRIVES), _of(robot, ("Laser",))
    if len(drives) > 1:
        raise UsageError(f'expected a model with one drive, "{usable[0]}" has {_names(drives)}')
    if settings.lidar is not None:
        lidars = [each for each in lidars if each["name"] == settings.lidar]
    if len(lidars) != 1:
        known = ", ".join(each["name"] for each in _of(robot, ("Laser",)))
        raise UsageError(f"expected the argument lidar, one of: {known}; found {settings.lidar!r}")
    return robot, drives[0], lidars[0]


def describe_robot(robot: Content, drive: Content, lidar: Content, s: NavigationSettings) -> Robot:
    """Describes a robot of a world that has been loaded, so that its values are known to be right.

    Args:
        robot: its entry in the world.
        drive: its drive.
        lidar: its lidar.
        s: the settings.
    """
    speed = _velocity_limit(drive, "linear_dynamics") or s.speed_limit
    kind = _kind(drive)
    if kind == "TricycleDrive":
        angle = float(drive.get("max_steer_angle") or 0.0) or s.steer_limit
        actions: Tuple[float, ...] = (speed, angle)
        velocities = (speed, 0.0, s.yaw_rate_limit)
    else:
        turning = _velocity_limit(drive, "angular_dynamics") or s.yaw_rate_limit
        is_omni = kind == "OmniDrive"
        actions = (speed, speed, turning) if is_omni else (speed, turning)
        velocities = (speed, speed if is_omni else 0.0, turning)
    return Robot(
        name=robot["name"],
        drive=drive["name"],
        lidar=lidar["name"],
        max_range=float(lidar["range"]),
        beams=_beams(lidar),
        action_limits=actions,
        velocity_limits=velocities,
    )


def set_beams(lidar: Content, beams: int) -> None:
    """Gives a lidar another number of beams over the same angle.

    The angle is that from the first beam to the last one, unless this is nearly a whole turn: then
    the last beam is one increment before the first one.
    """
    angle = lidar["angle"]
    low, high = float(angle["min"]), float(angle["max"])
    increment = float(angle["increment"])
    reach = high - low
    if abs(reach) + abs(increment) > math.tau - 1e-3:  # all around
        step = math.copysign(math.tau, increment) / beams
    else:
        step = reach / (beams - 1) if beams > 1 else increment
    lidar["angle"] = {"min": low, "max": low + step * (beams - 1), "increment": step}


def scale_footprints(robot: Content, scale: float) -> None:
    """Makes all footprints of a model larger or smaller, about the origins of their bodies."""
    for body in robot["model"]["bodies"]:
        for footprint in body.get("footprints") or ():
            if "radius" in footprint:
                footprint["radius"] = scale * float(footprint["radius"])
            for key in ("center", "points"):
                if key in footprint:
                    footprint[key] = (scale * np.array(footprint[key], dtype=float)).tolist()


def _beams(lidar: Content) -> int:
    angle = {key: float(value) for key, value in lidar["angle"].items()}
    steps = (angle["max"] - angle["min"]) / angle["increment"] if angle["increment"] else 0.0
    return math.floor(steps + 1e-2) + 1


def _velocity_limit(drive: Content, key: str) -> float:
    return float((drive.get(key) or {}).get("velocity_limit") or 0.0)


def _of(entry: Content, kinds: Tuple[str, ...]) -> List[Content]:
    """The plugins of a model that are of one of these types, and are not switched off."""
    plugins = entry["model"].get("plugins") or ()
    return [each for each in plugins if _kind(each) in kinds and each.get("enabled") is not False]


def _kind(plugin: Content) -> str:
    return str(plugin.get("type")).rpartition("::")[2]


def _kinds(entry: Content) -> str:
    kinds = [_kind(each) for each in entry["model"].get("plugins") or ()]
    return ", ".join(kinds) or "no plugins"


def _names(entries: Any) -> str:
    names = [each if isinstance(each, str) else str(each["name"]) for each in entries]
    return ", ".join(names) or "none"
