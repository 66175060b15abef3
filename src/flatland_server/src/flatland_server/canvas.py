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
            corners: corners of a simple polygon [m], in either order: shape (n, 2).
            fill: colour of the inside; None leaves it as it is.
            outline: colour of the outline; None draws none.
            width: width of the outline [px].
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
            center: x, y of the centre [m].
            radius: radius [m].
            fill: colour of the inside; None leaves it as it is.
            outline: colour of the outline; None draws none.
            width: width of the outline [px].
        """

    @abstractmethod
    def lines(self, segments: Segments, color: Rgba, width: float = 1.0) -> None:
        """Draws line segments.

        Args:
            segments: x1, y1, x2, y2 [m]: shape (n, 4).
            color: colour and opacity of all lines.
            width: width of the lines [px].
        """

    @abstractmethod
    def path(self, points: Points, color: Rgba, width: float = 1.0) -> None:
        """Draws a line from each point to the next.

        Args:
            points: corners of the line [m]: shape (n, 2).
            color: colour and opacity of the line.
            width: width of the line [px].
        """

    @abstractmethod
    def dots(self, points: Points, color: Rgba, size: float = 3.0) -> None:
        """Draws round dots.

        Args:
            points: centres of the dots [m]: shape (n, 2).
            color: colour and opacity of all dots.
            size: diameter of a dot [px].
        """

    @abstractmethod
    def label(self, point: Point, text: str, color: Rgba) -> None:
        """Writes a short text to the right of a point, and below it.

        Args:
            point: x, y of the top left corner of the text [m].
            text: one line.
            color: colour and opacity of the text.
        """
