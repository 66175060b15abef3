"""Screenshots of a virtual screen, and their pixels of a colour."""

from pathlib import Path
from typing import Dict, Sequence

import numpy as np
from PIL import Image, ImageGrab

FOLDER = Path(__file__).resolve().parents[3] / "build" / "screenshots"


class Screenshots:
    """Takes screenshots; the last of each name is kept.

    Args:
        display: name of the X display.
        prefix: prefix of the names of the files.
    """

    def __init__(self, display: str, prefix: str) -> None:
        self._display, self._prefix = display, prefix
        self._last: Dict[str, Image.Image] = {}

    def take(self, name: str) -> np.ndarray:
        """A screenshot: colours, uint8 of shape (height, width, 3)."""
        self._last[name] = ImageGrab.grab(xdisplay=self._display)
        return np.asarray(self._last[name])

    def save(self) -> None:
        """Writes the last screenshot of each name as a file; once, since it takes its time."""
        FOLDER.mkdir(parents=True, exist_ok=True)
        for name, picture in self._last.items():
            picture.save(FOLDER / f"{self._prefix}_{name}.png", compress_level=1)


def near(pixels: np.ndarray, color: Sequence[int], tolerance: int) -> np.ndarray:
    """The pixels that differ from the colour by at most the tolerance in each channel.

    Args:
        pixels: colours, uint8 of shape (height, width, 3).
        color: red, green and blue.
        tolerance: greatest difference in each channel.

    Returns:
        Booleans of shape (height, width).
    """
    # Channel by channel: ten times as fast as differences over the last axis. What is below the
    # least value becomes a large one in uint8: a single comparison does for both bounds.
    found = np.ones(pixels.shape[:2], dtype=bool)
    for channel, value in enumerate(color):
        least, greatest = max(value - tolerance, 0), min(value + tolerance, 255)
        found &= pixels[..., channel] - np.uint8(least) <= np.uint8(greatest - least)
    return found
