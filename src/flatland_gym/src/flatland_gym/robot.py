"""The robot of a world: its properties for environments, and changes to its model."""

import math
from dataclasses import dataclass
from typing import Any, Dict, Tuple

import numpy as np
from gymnasium import spaces

from flatland2d import UsageError, find_robot
from flatland_gym.settings import NavigationSettings
from flatland_server import FloatArray, ModelPlugin, World

Content = Dict[str, Any]
"""A world, a model or a plugin as plain data; see `flatland2d.world_content`."""

_ALIKE = 1e-3
"""Differences between left and right that do not count [m or rad]."""


@dataclass(frozen=True)
class Robot:
    """The robot of a world.

    Attributes:
        name: the model's name.
        drive: the name of its drive.
        lidar: the name of its lidar.
        max_range: the lidar's max range [m].
        beams: number of the lidar's beams.
        action_limits: the largest value of each part of an action; the least is its negative.
        velocity_limits: of forwards, to the left and turning [m/s, m/s, rad/s]; 0 for a direction
            in which it cannot be driven.
        mirrored_beams: for each beam the one in its mirror image, as far to the other side; empty
            if the lidar does not look to both sides alike.
    """

    name: str
    drive: str
    lidar: str
    max_range: float
    beams: int
    action_limits: Tuple[float, ...]
    velocity_limits: Tuple[float, float, float]
    mirrored_beams: Tuple[int, ...]

    @classmethod
    def of(cls, world: World, name: str, lidar: str, settings: NavigationSettings) -> "Robot":
        """Describes a robot of a world.

        Args:
            world: world to look in.
            name: the model's name.
            lidar: the name of its lidar.
            settings: settings with the limits for a drive without limits of its own.

        Raises:
            ModelError: it has no drive, or several ones.
        """
        found = find_robot(world, name, lidar)
        speed, turning = settings.speed_limit, settings.yaw_rate_limit
        columns = found.core_drive.columns
        default = (speed, settings.steer_limit) if found.is_steered else (speed, speed, turning)
        limits = {k: own or default[k] for k, own in zip(columns, found.core_drive.limits)}
        if found.is_steered:
            velocities = limits[0], 0.0, turning
        else:
            velocities = limits.get(0, 0.0), limits.get(1, 0.0), limits.get(2, 0.0)
        return cls(
            name=name,
            drive=found.drive.name,
            lidar=lidar,
            max_range=found.core_lidar.range,
            beams=len(found.core_lidar.lidar.ranges()),
            action_limits=tuple(limits[k] for k in columns),
            velocity_limits=velocities,
            mirrored_beams=_mirrored_beams(found.lidar),
        )

    @property
    def actions(self) -> FloatArray:
        """`action_limits` as an array."""
        return np.array(self.action_limits)

    def action_space(self) -> spaces.Box:
        """The commands of the drive in its own units, within its limits: a new space."""
        high = self.actions.astype(np.float32)
        return spaces.Box(-high, high, dtype=np.float32)


def _mirrored_beams(lidar: ModelPlugin) -> Tuple[int, ...]:
    """`Robot.mirrored_beams`; none for a plugin without the `angles` and `origin` of a Laser."""
    angles, origin = getattr(lidar, "angles", None), getattr(lidar, "origin", None)
    if angles is None or origin is None or abs(origin.y) > _ALIKE:
        return ()
    turns = np.mod(angles + origin.yaw, math.tau)
    order = np.argsort(turns)
    places = np.searchsorted(turns[order], np.mod(-turns - _ALIKE, math.tau))
    found = order[places % len(order)]
    differences = np.mod(turns + turns[found] + _ALIKE, math.tau)
    return tuple(found.tolist()) if (differences <= 2.0 * _ALIKE).all() else ()


def set_beams(lidar: Content, beams: int) -> None:
    """Gives a lidar another number of beams over the same angle.

    The angle is that from the first beam to the last one, unless this is nearly a whole turn: then
    the last beam is one increment before the first one.

    Raises:
        UsageError: it has no angle as a Laser has.
    """
    try:
        low, high, increment = (float(lidar["angle"][k]) for k in ("min", "max", "increment"))
    except (KeyError, TypeError, ValueError):
        raise UsageError(
            f'expected a Laser for the argument beams, found "{lidar["name"]}", a {lidar["type"]}'
        ) from None
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
