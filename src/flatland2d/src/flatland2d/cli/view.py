"""flatland view: a window on a world."""

import argparse

from flatland2d.cli.arguments import Subparsers, add_world, open_simulation, positive, size
from flatland2d.viewer.keys import help_lines
from flatland2d.viewer.viewer import Viewer


def add_parser(commands: Subparsers) -> None:
    """Adds the subcommand."""
    parser = commands.add_parser(
        "view",
        help="show a world in a window, and drive its robots",
        description="Show a world in a window, and drive its robots by the keyboard.",
        epilog="keys:\n" + "\n".join(f"  {line}" for line in help_lines()),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_world(parser)
    parser.add_argument("--follow", metavar="MODEL", help="keep this model in the middle")
    parser.add_argument(
        "--size", type=size, default=(1280, 800), metavar="WxH", help="of the window [px]"
    )
    parser.add_argument(
        "--rate",
        type=positive,
        default=1.0,
        metavar="R",
        help="simulated seconds per second of real time (default: 1)",
    )
    parser.set_defaults(execute=_execute)


def _execute(options: argparse.Namespace) -> int:
    from flatland2d.viewer.window import Window  # needs pygame

    with open_simulation(options, raise_failures=False) as simulation:
        viewer = Viewer(simulation, options.size, rate=options.rate, follow=options.follow)
        Window(viewer, f"{options.world} - Flatland").run()
    return 0
