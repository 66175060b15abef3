"""A canvas that writes SVG: https://www.w3.org/TR/SVG11/."""

from html import escape
from typing import List, Optional

from flatland2d.rendering.view import View
from flatland_server.arrays import FloatArray, Segments
from flatland_server.canvas import Canvas, Points, Rgba
from flatland_server.geometry import Point

_LABEL_OFFSET = (4.0, 18.0)  # px; to the base line
_FONT = (
    'font-family="sans-serif" font-size="18" '
    'stroke="#eeeeec" stroke-width="4" stroke-opacity="0.8" paint-order="stroke"'
)


class SvgCanvas(Canvas):
    """Collects SVG elements.

    Args:
        view: what the picture shows.
        background: colour of the background.
    """

    def __init__(self, view: View, background: Rgba) -> None:
        self.view = view
        self._elements: List[str] = []
        self._add(f'<rect width="100%" height="100%" {_paint("fill", background)}/>')

    def document(self) -> str:
        """The SVG file's content."""
        width, height = self.view.size
        head = (
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
            f'viewBox="0 0 {width} {height}">'
        )
        return "\n".join([head, *self._elements, "</svg>", ""])

    def area(
        self,
        corners: Points,
        fill: Optional[Rgba] = None,
        outline: Optional[Rgba] = None,
        width: float = 1.0,
    ) -> None:
        places = " ".join(_places(self.view.pixels(corners)))
        self._add(f'<polygon points="{places}" {_style(fill, outline, width)}/>')

    def disc(
        self,
        center: Point,
        radius: float,
        fill: Optional[Rgba] = None,
        outline: Optional[Rgba] = None,
        width: float = 1.0,
    ) -> None:
        x, y = self.view.pixels([center])[0]
        self._add(
            f'<circle cx="{x:.2f}" cy="{y:.2f}" r="{radius * self.view.scale:.2f}" '
            f"{_style(fill, outline, width)}/>"
        )

    def lines(self, segments: Segments, color: Rgba, width: float = 1.0) -> None:
        places = _places(self.view.pixels(segments))
        moves = [f"M{a}L{b}" for a, b in zip(places[::2], places[1::2])]
        if moves:
            self._add(f'<path d="{"".join(moves)}" {_style(None, color, width)}/>')

    def path(self, points: Points, color: Rgba, width: float = 1.0) -> None:
        places = " ".join(_places(self.view.pixels(points)))
        self._add(f'<polyline points="{places}" {_style(None, color, width)}/>')

    def dots(self, points: Points, color: Rgba, size: float = 3.0) -> None:
        # A line of no length with round ends is a dot.
        moves = "".join(f"M{place}h0" for place in _places(self.view.pixels(points)))
        if moves:
            self._add(f'<path d="{moves}" {_style(None, color, size)}/>')

    def label(self, point: Point, text: str, color: Rgba) -> None:
        x, y = self.view.pixels([point])[0] + _LABEL_OFFSET
        fill = _paint("fill", color)
        self._add(
            f'<text x="{x:.2f}" y="{y:.2f}" {_FONT} {fill}>{escape(text, quote=False)}</text>'
        )

    def _add(self, element: str) -> None:
        self._elements.append(element)


def _places(pixels: FloatArray) -> List[str]:
    return [f"{x:.2f},{y:.2f}" for x, y in pixels.tolist()]


def _style(fill: Optional[Rgba], line: Optional[Rgba], width: float) -> str:
    words = [_paint("fill", fill)]
    if line is not None:
        ends = 'stroke-linecap="round" stroke-linejoin="round"'
        words += [_paint("stroke", line), f'stroke-width="{width:.2f}" {ends}']
    return " ".join(words)


def _paint(name: str, color: Optional[Rgba]) -> str:
    if color is None:
        return f'{name}="none"'
    parts = ",".join(str(round(255 * min(max(part, 0.0), 1.0))) for part in color[:3])
    opacity = f' {name}-opacity="{color[3]:.3g}"' if color[3] < 1.0 else ""
    return f'{name}="rgb({parts})"{opacity}'
