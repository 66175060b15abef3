"""The canvas for pictures of a world, drawn by the framework and by plugins."""

from abc import ABC, abstractmethod
from typing import Optional, Sequence, Tuple, Union

from flatland_server.arrays import FloatArray, Segments
from flatland_server.geometry import Point

Rgba = Tuple[float, float, float, float]
"""Red, green, blue and opacity, each from 0 to 1."""

Points = Union[FloatArray, Sequence[Point]]
"""Positions in the world [m]: shape (n, 2)."""


class Canvas(ABC):
    """A picture of the world, seen from above. Later shapes cover earlier ones.

    Positions and lengths are in metres, in the frame of the world. Widths of lines and sizes of
    dots are in pixels, and do not depend on the scale of the picture.
    """

    @abstractmethod
    def area(
        self,
        corners: Points,
        fill: Optional[Rgba] = None,
        outline: Optional[Rgba] = None,
        width: float = 1.0,
    ) -> None:
        """Draws a polygon.

        Args:
            corners: of a simple polygon, in either order.
            fill: colour of the inside; None leaves it as it is.
            outline: colour of the outline; None draws none.
            width: the outline's width.
        """

    @abstractmethod
    def disc(
        self,
        center: Point,
        radius: float,
        fill: Optional[Rgba] = None,
        outline: Optional[Rgba] = None,
        width: float = 1.0,
    ) -> None:
        """Draws a disc.

        Args:
            center: the disc's center.
            radius: the disc's radius.
            fill: colour of the inside; None leaves it as it is.
            outline: colour of the outline; None draws none.
            width: the outline's width.
        """

    @abstractmethod
    def lines(self, segments: Segments, color: Rgba, width: float = 1.0) -> None:
        """Draws line segments.

        Args:
            segments: shape (n, 4), x1, y1, x2, y2.
            color: the lines' color.
            width: the lines' width.
        """

    @abstractmethod
    def path(self, points: Points, color: Rgba, width: float = 1.0) -> None:
        """Draws a line from each point to the next.

        Args:
            points: the corners of the line.
            color: the line's color.
            width: the line's width.
        """

    @abstractmethod
    def dots(self, points: Points, color: Rgba, size: float = 3.0) -> None:
        """Draws round dots.

        Args:
            points: their centres.
            color: the dots' color.
            size: their diameter.
        """

    @abstractmethod
    def label(self, point: Point, text: str, color: Rgba) -> None:
        """Writes a short text to the right of a point, and below it.

        Args:
            point: the top left corner of the text.
            text: one line.
            color: the text's color.
        """
