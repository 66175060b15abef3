"""Rendering of environments: pictures, a window, and a line of text."""

import importlib.util
import logging
import os
from typing import Any, List, Optional, Sequence

import numpy as np
from PIL import Image, ImageDraw

from flatland2d import MissingPackageError, Point, Pose, Simulation, UsageError

logger = logging.getLogger(__name__)

RENDER_MODES = ("human", "rgb_array", "ansi")

_WITHOUT_SCREEN = ("dummy", "evdev", "offscreen")
"""SDL's video drivers without output, its possible choices on a machine without a screen."""

_SIZE = (480, 480)  # px
_WIDTH = 10.0  # m
_GOAL = (46, 160, 67)


def picture(simulation: Simulation, robot: str, goal: Point, goal_radius: float) -> Any:
    """The surroundings of a robot with its lidar and its goal: uint8, shape (480, 480, 3).

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


def usable(modes: Sequence[str]) -> List[str]:
    """The render modes for which the packages are installed."""
    has_pygame = importlib.util.find_spec("pygame") is not None
    return [mode for mode in modes if mode != "human" or has_pygame]


class Window:
    """A window that shows pictures in real time; opened with the first one.

    Without a screen, nothing is shown, and the log says so once.

    Args:
        title: of the window.
        period: simulated time between two pictures [s].
    """

    def __init__(self, title: str, period: float) -> None:
        self._title = title
        self._rate = 1.0 / period
        self._pygame: Any = None
        self._screen: Any = None  # None: there is none

    def show(self, frame: Any) -> None:
        """Shows a picture, and waits until the time of the next one.

        Raises:
            MissingPackageError: pygame is not installed.
        """
        if self._pygame is None:
            self._open()
        if self._screen is None:
            return
        pygame = self._pygame
        pygame.event.pump()
        surface = pygame.surfarray.make_surface(frame.transpose(1, 0, 2))
        self._screen.blit(surface, (0, 0))
        pygame.display.flip()
        self._clock.tick(self._rate)

    def close(self) -> None:
        """Closes the window."""
        if self._pygame is not None:
            self._pygame.display.quit()
            self._pygame = self._screen = None

    def _open(self) -> None:
        try:
            import pygame
        except ImportError:
            raise MissingPackageError(
                "render_mode=\"human\" needs pygame: pip install 'flatland2d[view]'"
            ) from None
        self._pygame = pygame
        reason = "there is no screen"
        try:
            pygame.display.init()
            driver = pygame.display.get_driver()
            if driver not in _WITHOUT_SCREEN or "SDL_VIDEODRIVER" in os.environ:
                self._screen = pygame.display.set_mode(_SIZE)
        except pygame.error as error:
            reason = str(error)
        if self._screen is None:
            logger.warning(
                'the window cannot be opened: %s; render_mode="rgb_array" needs none', reason
            )
            return
        pygame.display.set_caption(self._title)
        self._clock = pygame.time.Clock()
