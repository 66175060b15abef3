"""flatland worlds: lists the worlds that come with Flatland."""

import argparse

from flatland2d.cli.arguments import Subparsers
from flatland_server.config.shipped_worlds import shipped_worlds


def add_parser(commands: Subparsers) -> None:
    """Adds the subcommand."""
    description = "List the worlds that come with Flatland: their names, and their files."
    parser = commands.add_parser("worlds", help="list worlds", description=description)
    parser.set_defaults(execute=_execute)


def _execute(_: argparse.Namespace) -> int:
    worlds = shipped_worlds()
    width = max(map(len, worlds), default=0)
    for name, path in worlds.items():
        print(f"{name:{width}}  {path}")
    return 0
