"""flatland worlds: lists the worlds that come with Flatland, and imports those of BARN."""

import argparse
from pathlib import Path

from flatland2d.barn import read_barn, write_barn
from flatland2d.cli.arguments import Subparsers
from flatland_server.config import shipped_worlds
from flatland_server.exceptions import counted


def add_parser(commands: Subparsers) -> None:
    """Adds the subcommand."""
    description = "List the worlds that come with Flatland: their names, and their files."
    parser = commands.add_parser("worlds", help="list worlds", description=description)
    parser.add_argument(
        "--import-barn",
        type=Path,
        metavar="FOLDER",
        help="write the worlds of BARN in FOLDER as ours, with a scenario file for flatland sweep",
    )
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("barn"),
        metavar="DIR",
        help="with --import-barn: the folder to write (default: %(default)s)",
    )
    parser.set_defaults(execute=_execute)


def _execute(options: argparse.Namespace) -> int:
    if options.import_barn is not None:
        found = read_barn(options.import_barn)
        write_barn(found, options.out)
        print(f"{counted(len(found), 'world')}; flatland sweep {options.out}/scenarios.yaml")
        return 0
    worlds = shipped_worlds()
    width = max(map(len, worlds), default=0)
    for name, path in worlds.items():
        print(f"{name:{width}}  {path}")
    return 0
