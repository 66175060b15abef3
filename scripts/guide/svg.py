"""A few shapes of SVG, with numbers rounded so that a figure made again is the same file."""

from typing import Iterable, List, Tuple
from xml.sax.saxutils import escape

TEAL, BLUE, ORANGE, RED, GREY = "#00796b", "#1565c0", "#ef6c00", "#c62828", "#616161"
PALE = {TEAL: "#e0f2f1", BLUE: "#e3f2fd", ORANGE: "#fff3e0", RED: "#ffebee", GREY: "#f5f5f5"}


class Svg:
    """A drawing, in pixels from its top left corner, on white."""

    def __init__(self, width: int, height: int, title: str) -> None:
        self._parts: List[str] = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
            f'width="{width}" height="{height}" font-family="sans-serif" role="img">',
            f"<title>{escape(title)}</title>",
            '<defs><marker id="arrow" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" '
            'markerHeight="7" orient="auto-start-reverse"><path d="M0,0 L8,4 L0,8 z" '
            f'fill="{GREY}"/></marker></defs>',
            f'<rect width="{width}" height="{height}" fill="#ffffff"/>',
        ]

    def box(self, x: float, y: float, width: float, height: float, color: str = TEAL) -> None:
        """A rectangle with round corners."""
        self._parts.append(
            f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="5" '
            f'fill="{PALE[color]}" stroke="{color}"/>'
        )

    def text(
        self,
        x: float,
        y: float,
        text: str,
        size: int = 13,
        color: str = "#212121",
        anchor: str = "middle",
        bold: bool = False,
    ) -> None:
        """A line of text."""
        weight = ' font-weight="bold"' if bold else ""
        self._parts.append(
            f'<text x="{x:g}" y="{y:g}" font-size="{size}" fill="{color}" '
            f'text-anchor="{anchor}"{weight}>{escape(text)}</text>'
        )

    def line(
        self,
        points: Iterable[Tuple[float, float]],
        color: str = GREY,
        width: float = 1.2,
        arrow: bool = False,
        dashed: bool = False,
    ) -> None:
        """A line through points, with an arrow at its end."""
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        end = ' marker-end="url(#arrow)"' if arrow else ""
        dash = ' stroke-dasharray="4 3"' if dashed else ""
        self._parts.append(
            f'<polyline points="{path}" fill="none" stroke="{color}" '
            f'stroke-width="{width:g}"{dash}{end}/>'
        )

    def segments(
        self,
        pairs: Iterable[Tuple[Tuple[float, float], Tuple[float, float]]],
        color: str = GREY,
        width: float = 1.0,
    ) -> None:
        """Many lines, each between two points, as one path."""
        path = "".join(f"M{a:.1f},{b:.1f}L{c:.1f},{d:.1f}" for (a, b), (c, d) in pairs)
        self._parts.append(f'<path d="{path}" stroke="{color}" stroke-width="{width:g}"/>')

    def area(self, points: Iterable[Tuple[float, float]], color: str, opacity: float) -> None:
        """A polygon."""
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        self._parts.append(f'<polygon points="{path}" fill="{color}" fill-opacity="{opacity:g}"/>')

    def dot(self, x: float, y: float, radius: float = 3, color: str = TEAL) -> None:
        """A disc."""
        self._parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:g}" fill="{color}"/>')

    def __str__(self) -> str:
        return "\n".join([*self._parts, "</svg>", ""])
