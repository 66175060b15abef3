"""flatland check: reports all that is wrong in files."""

import argparse

from flatland_server.cli.arguments import Subparsers
from flatland_server.config.shipped_worlds import shipped_worlds
from flatland_server.tools import check_world


def add_parser(commands: Subparsers) -> None:
    """Adds the subcommand."""
    description = (
        "Check world, model and map files. All that is wrong is reported at once, as "
        "file:line:column: message."
    )
    parser = commands.add_parser("check", help="check files", description=description)
    check_world.add_arguments(parser)
    parser.set_defaults(execute=_execute, parser=parser)


def _execute(options: argparse.Namespace) -> int:
    worlds = shipped_worlds()
    options.files = [str(worlds.get(name, name)) for name in options.files]
    return check_world.execute(options, options.parser)
