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
from flatland2d.simulation import Simulation
from flatland2d.viewer.trail import Trail

_TRAIL_PERIOD = 0.05  # s


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
    parser.add_argument(
        "--trail", metavar="MODEL", help="draw its way in this time, and the way by its odometry"
    )
    parser.add_argument("--names", action="store_true", help="write the names of the models")
    parser.set_defaults(execute=_execute)


def _execute(options: argparse.Namespace) -> int:
    with open_simulation(options) as simulation:
        steps = round(options.time / simulation.step_size)
        trail = Trail(simulation)
        if options.trail is None:
            if steps:
                simulation.step(steps)
        else:
            _follow(trail, simulation.models[options.trail].name, simulation, steps)
        simulation.save_picture(
            options.output,
            options.size,
            follow=options.follow,
            width=options.width,
            sensors=options.sensors,
            names=options.names,
            trails=trail.lines,
        )
    return 0


def _follow(trail: Trail, model: str, simulation: Simulation, steps: int) -> None:
    """Makes steps, and notes the way of a model."""
    period = max(1, round(_TRAIL_PERIOD / simulation.step_size))
    trail.note(model, reads_odometry=True)
    for done in range(0, steps, period):
        simulation.step(min(period, steps - done))
        trail.note(model, reads_odometry=True)
