"""flatland serve: simulates a world for web pages, roslib and Foxglove."""

import argparse
import secrets
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from flatland2d.cli.arguments import Subparsers, add_rate, add_world, whole_from, world_options
from flatland2d.cli.run import interrupts
from flatland_server.exceptions import MissingPackageError


def add_parser(commands: Subparsers) -> None:
    """Adds the subcommand."""
    parser = commands.add_parser(
        "serve",
        help="simulate a world for web pages, roslib and Foxglove",
        description="Simulate a world for clients: a page of its own, programs with roslib or "
        "roslibpy, and Foxglove. Ctrl-C ends it.",
    )
    add_world(parser)
    add_rate(parser)
    parser.add_argument("--paused", action="store_true", help="begin with a pause")
    parser.add_argument(
        "--port",
        type=whole_from(0),
        default=9090,
        help="of rosbridge and the page; 0 takes a free one (default: %(default)s)",
    )
    parser.add_argument(
        "--foxglove-port",
        type=whole_from(0),
        default=8765,
        metavar="PORT",
        help="of Foxglove; 0 takes a free one (default: %(default)s)",
    )
    parser.add_argument(
        "--host",
        default="127.0.0.1",
        help="address to listen at; by default only programs on this machine can connect",
    )
    parser.add_argument(
        "--token",
        nargs="?",
        const=True,
        help="clients must know it: ws://HOST:PORT/?token=TOKEN; without a value a random one",
    )
    parser.add_argument(
        "--origin",
        action="append",
        default=[],
        help='pages of this origin may connect, too: https://example.org; "null": pages from files',
    )
    parser.add_argument(
        "--client-memory",
        type=whole_from(1),
        default=16,
        metavar="MB",
        help="what is kept for a client: it loses old messages of topics, and with more of other "
        "things its connection (default: %(default)s)",
    )
    parser.add_argument(
        "--state-folder",
        type=Path,
        metavar="FOLDER",
        help="where clients may save and load states; by default they cannot",
    )
    parser.add_argument(
        "--ros2", action="store_true", help="for nodes of ROS 2, too, in the domain ROS_DOMAIN_ID"
    )
    parser.add_argument(
        "--cmd-vel-type",
        choices=("Twist", "TwistStamped"),
        default="",
        help="of topics of commands in ROS 2 (default: as Nav2 of the distribution sends them)",
    )
    parser.add_argument(
        "--ros-args",
        nargs=argparse.REMAINDER,
        default=[],
        metavar="ARGUMENT",
        help="all that follows is for ROS 2, such as -r /scan:=/lidar",
    )
    parser.add_argument(
        "--wall-clock-stamps",
        action="store_true",
        help="stamps of real time, without /clock, for nodes without use_sim_time; not with --rate",
    )
    parser.add_argument(
        "--tf-by-namespace",
        action="store_true",
        help="transforms of robots in namespaces go to NAMESPACE/tf and NAMESPACE/tf_static, and "
        "their frames have no prefix",
    )
    parser.set_defaults(execute=_execute, parser=parser)


def bridge(command: str) -> Any:
    """The module of the bridge's server, which only this and `flatland view` import.

    Raises:
        MissingPackageError: a package that it needs is missing.
    """
    try:
        from flatland_bridge import server
    except ImportError as error:
        if error.name is None or error.name.startswith("flatland"):
            raise
        raise MissingPackageError(
            f"flatland {command} needs {error.name}: "
            "pip install 'cbor2>=6.2' orjson 'websockets>=14'"
        ) from None
    return server


def _execute(options: argparse.Namespace) -> int:
    parts = bridge("serve")
    token = secrets.token_urlsafe(16) if options.token is True else options.token
    access = parts.Access(options.host, token, options.origin)
    if not access.is_local:
        known = "who knows the token" if token else "on the network"
        print(f"warning: everyone {known} can control the simulation", file=sys.stderr)
    with ExitStack() as stack:
        ros2 = None
        if options.ros2 or options.ros_args:
            ros_arguments = ["--ros-args", *options.ros_args]
            ros2 = parts.open_ros2(access, ros_arguments, options.cmd_vel_type)
            stack.callback(ros2.close)
        server = stack.enter_context(
            parts.Server(
                options.world,
                **world_options(options),
                rate=options.rate,
                state_folder=options.state_folder,
                is_paused=options.paused,
                access=access,
                rosbridge_port=options.port,
                foxglove_port=options.foxglove_port,
                client_memory=options.client_memory * 1_000_000,
                wall_clock_stamps=options.wall_clock_stamps,
                tf_by_namespace=options.tf_by_namespace,
                ros2=ros2,
            )
        )
        is_interrupted = stack.enter_context(interrupts())
        print(f"page: {server.clients.url(parts.ROSBRIDGE, 'http')}")
        print(f"rosbridge: {server.clients.url(parts.ROSBRIDGE, 'ws')}")
        print(f"Foxglove: {server.clients.url(parts.FOXGLOVE, 'ws')}", flush=True)
        if ros2 is not None:
            print(f"ROS 2: domain {ros2.domain}, {ros2.distribution}", flush=True)
        server.run(lambda: not is_interrupted())
    return 0
