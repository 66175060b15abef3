"""flatland render: draws a world into a file."""

import argparse
from pathlib import Path

from flatland2d.cli.arguments import (
    Subparsers,
    add_world,
    not_negative,
    open_simulation,
    positive,
    size,
)


def add_parser(commands: Subparsers) -> None:
    """Adds the subcommand."""
    parser = commands.add_parser(
        "render",
        help="draw a world",
        description="Draw a world, seen from above, into a PNG, JPEG or SVG file.",
    )
    add_world(parser)
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        metavar="FILE",
        help="its ending says what it is: .png, .svg ...",
    )
    parser.add_argument(
        "--size", type=size, metavar="WxH", help="of the picture [px]; by default as the world"
    )
    parser.add_argument("--follow", metavar="MODEL", help="show the surroundings of this model")
    parser.add_argument(
        "--width",
        type=positive,
        default=10.0,
        metavar="M",
        help="of these surroundings [m] (default: %(default)s)",
    )
    parser.add_argument(
        "--time",
        type=not_negative,
        default=0.0,
        metavar="S",
        help="simulate so long before [s] (default: %(default)s)",
    )
    parser.add_argument(
        "--sensors", action="store_true", help="draw what sensors measure, such as lidars"
    )
    parser.add_argument("--names", action="store_true", help="write the names of the models")
    parser.set_defaults(execute=_execute)


def _execute(options: argparse.Namespace) -> int:
    with open_simulation(options) as simulation:
        steps = round(options.time / simulation.step_size)
        if steps:
            simulation.step(steps)
        simulation.save_picture(
            options.output,
            options.size,
            follow=options.follow,
            width=options.width,
            sensors=options.sensors,
            names=options.names,
        )
    return 0
