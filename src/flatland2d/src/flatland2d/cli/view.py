"""flatland view: a world on a page in the browser."""

import argparse
import secrets
from pathlib import Path
from urllib.parse import quote

from flatland2d.browser import open_in_browser
from flatland2d.cli.arguments import Subparsers, add_rate, add_world, whole_from, world_options
from flatland2d.cli.run import interrupts
from flatland2d.cli.serve import bridge
from flatland_server.config import find_world, is_shipped


def add_parser(commands: Subparsers) -> None:
    """Adds the subcommand."""
    parser = commands.add_parser(
        "view",
        help="show a world in the browser, and drive its robots",
        description="Show a world on a page in the browser, and drive its robots; F1 shows the "
        "page's keys. Ctrl-C ends it.",
    )
    add_world(parser)
    parser.add_argument("--follow", metavar="MODEL", help="keep this model in the middle")
    add_rate(parser)
    parser.add_argument(
        "--port", type=whole_from(0), default=0, help="of the page; by default a free one"
    )
    parser.set_defaults(execute=_execute)


def _execute(options: argparse.Namespace) -> int:
    parts = bridge("view")
    world = find_world(options.world)
    server = parts.Server(
        options.world,
        **world_options(options),
        rate=options.rate,
        state_folder=Path.cwd() if is_shipped(world) else world.absolute().parent,
        access=parts.Access(token=secrets.token_urlsafe(16)),
        rosbridge_port=options.port,
        foxglove_port=None,
        with_history=True,
    )
    with server, interrupts() as is_interrupted:
        page = server.clients.url(parts.ROSBRIDGE, "http")
        if options.follow is not None:
            server.manager.world.get_model(options.follow)
            page += f"&follow={quote(options.follow)}"
        open_in_browser(page)
        server.run(lambda: not is_interrupted())
    return 0
