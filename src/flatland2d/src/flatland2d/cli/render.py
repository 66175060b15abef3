"""flatland render: draws a world into a file."""

import argparse
import math
from pathlib import Path
from typing import List, Optional, Tuple

from flatland2d.cli.arguments import (
    Subparsers,
    add_world,
    not_negative,
    open_simulation,
    positive,
    size,
)
from flatland2d.simulation import Simulation
from flatland_server.exceptions import FlatlandError
from flatland_server.geometry import Point, Pose

_TRAIL_PERIOD = 0.05  # s
_TRAIL_STEP = 0.05  # m


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
        trails: List[List[Point]] = []
        if options.trail is not None:
            trails = _trails(options.trail, simulation, steps)
        elif steps:
            simulation.step(steps)
        simulation.save_picture(
            options.output,
            options.size,
            follow=options.follow,
            width=options.width,
            sensors=options.sensors,
            names=options.names,
            trails=trails,
        )
    return 0


def _trails(name: str, simulation: Simulation, steps: int) -> List[List[Point]]:
    """Makes steps, and returns the way of a model, and the way that its odometry believes in.

    Odometry is in a frame of its own: it begins where the model is at its first message.
    """
    model = simulation.models[name]
    drive = next(iter(model.drives), "")
    way: List[Point] = []
    belief: List[Point] = []
    anchor: Optional[Tuple[Pose, Pose]] = None
    period = max(1, round(_TRAIL_PERIOD / simulation.step_size))
    for done in range(0, steps + 1, period):
        place = model.model.pose
        if not way or math.dist(way[-1], place[:2]) >= _TRAIL_STEP:
            way.append(place[:2])
            try:
                estimate = model.sensors[drive].read().pose if drive in model.sensors else None
            except FlatlandError:  # none yet
                estimate = None
            if estimate is not None:
                anchor = anchor or (place, estimate)
                belief.append(anchor[0].compose(anchor[1].inverse().compose(estimate))[:2])
        if done < steps:
            simulation.step(min(period, steps - done))
    return [line for line in (way, belief) if line]
