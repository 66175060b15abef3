"""flatland map_to_lines: makes a layer of line segments from a map image."""

import argparse
from pathlib import Path

from flatland2d.cli.arguments import Subparsers, not_negative
from flatland2d.rendering.line_map_picture import save_line_map_picture
from flatland_server.config import to_path
from flatland_server.exceptions import FlatlandError
from flatland_server.maps import LineMap


def add_parser(commands: Subparsers) -> None:
    """Adds the subcommand."""
    parser = commands.add_parser(
        "map_to_lines",
        help="make a layer of line segments from a map image",
        description="Replace the outlines of a map of map_server by fewer, straight lines, for a "
        "layer of a world. Reads image, resolution, origin, occupied_thresh, negate and mode as "
        "map_server does.",
    )
    parser.add_argument("map", metavar="MAP", help="the YAML file of map_server")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help="the new YAML file (default: MAP_lines.yaml); the segments are written beside it",
    )
    parser.add_argument(
        "--tolerance",
        type=not_negative,
        metavar="M",
        help="the largest distance between outlines and lines [m] (default: of one pixel)",
    )
    parser.add_argument(
        "--picture", type=Path, metavar="FILE", help="draw both: .svg, to zoom in, or .png ..."
    )
    parser.set_defaults(execute=_execute)


def _execute(options: argparse.Namespace) -> int:
    source = to_path(options.map)
    output: Path = options.output or source.with_name(f"{source.stem}_lines.yaml")
    if output.exists() and output.samefile(source):
        raise FlatlandError(f"{output}: is the map itself; choose another file for the lines")
    if output.suffix == ".dat":
        raise FlatlandError(f"{output}: expected the name of a YAML file; its lines are in a .dat")
    line_map = LineMap.from_file(source, options.tolerance)
    line_map.write(output)
    if options.picture:
        save_line_map_picture(options.picture, line_map)
    print(
        f"{output}: {len(line_map.lines)} lines for {len(line_map.outlines)} segments of outlines, "
        f"at most {line_map.deviation:.3g} m apart"
    )
    return 0
