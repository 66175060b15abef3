"""Reads maps into wall segments: images and lists of line segments."""

from flatland_server.maps.line_map import LineMap
from flatland_server.maps.map_reader import MapConfig
from flatland_server.maps.simplify_outlines import TOLERANCES
from flatland_server.maps.wall_outlines import bright_pixels

__all__ = [
    "TOLERANCES",
    "LineMap",
    "MapConfig",
    "bright_pixels",
]
