"""Rendering of environments: pictures, and a line of text."""

from typing import TYPE_CHECKING, Any, Optional, Sequence

import numpy as np
from PIL import Image, ImageDraw

from flatland2d import Point, Pose, Simulation, UsageError

if TYPE_CHECKING:
    from flatland2d import PicturePage

RENDER_MODES = ("human", "rgb_array", "ansi")

_SIZE = (480, 480)  # px
_WIDTH = 10.0  # m
_GOAL = (46, 160, 67)


def picture(simulation: Simulation, robot: str, goal: Point, goal_radius: float) -> Any:
    """The area around a robot, with its lidar and its goal: uint8, shape (480, 480, 3).

    A goal outside of the picture is an arrow at its edge.
    """
    frame = simulation.render(_SIZE, follow=robot, width=_WIDTH, sensors=True)
    image = Image.fromarray(frame)
    draw = ImageDraw.Draw(image)
    pose = simulation.models[robot].pose
    scale = _SIZE[0] / _WIDTH
    middle = np.array(_SIZE) / 2
    offset = np.array([goal[0] - pose.x, pose.y - goal[1]]) * scale
    reach = float(np.abs(offset).max())
    if reach <= middle[0]:
        x, y = middle + offset
        radius = goal_radius * scale
        draw.ellipse((x - radius, y - radius, x + radius, y + radius), outline=_GOAL, width=3)
        draw.ellipse((x - 3, y - 3, x + 3, y + 3), fill=_GOAL)
    else:
        tip = middle + offset / reach * (middle[0] - 4)
        along = offset / np.hypot(*offset)
        across = np.array([-along[1], along[0]])
        corners = [tip, tip - 16 * along + 8 * across, tip - 16 * along - 8 * across]
        draw.polygon([tuple(corner) for corner in corners], fill=_GOAL)
    return np.array(image)


def status_line(time: float, pose: Any, goal: Any, distance: float) -> str:
    """An environment in a line of text."""
    x, y, yaw = Pose(*(float(value) for value in pose))
    return (
        f"{time:7.2f} s  robot ({x:.2f}, {y:.2f}) m, {yaw:+.2f} rad  "
        f"goal ({goal[0]:.2f}, {goal[1]:.2f}) m, {distance:.2f} m away"
    )


def check_render_mode(mode: Optional[str], modes: Sequence[str] = RENDER_MODES) -> None:
    """Raises a UsageError for an unknown mode."""
    if mode is not None and mode not in modes:
        known = ", ".join(map(repr, modes))
        raise UsageError(f"expected render_mode None or one of {known}, found {mode!r}")


def page_of(mode: Optional[str], period: float) -> "Optional[PicturePage]":
    """The page that shows an environment in real time; None in other modes than "human".

    Args:
        mode: the render mode.
        period: simulated time between two pictures [s].
    """
    if mode != "human":
        return None
    from flatland2d import PicturePage  # imports a web server

    return PicturePage("Flatland", 1.0 / period)
